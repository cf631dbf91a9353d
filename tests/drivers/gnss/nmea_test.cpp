#include "drivers/gnss/nmea.hpp"
#include "drivers/measurement/angles.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "fixtures/lidar/nmea_sentence.hpp"

namespace infuse::gnss {
namespace {

// Sentences from an HDL-32E of 2012 and a VLP-16 of 2016.
TEST(Nmea, ParsesSentencesOfRealReceivers) {
  const auto old =
      parse_nmea("$GPRMC,220243,A,3708.5809,N,12139.7813,W,028.8,158.3,111212,013.8,E,D*03\r\n");
  ASSERT_TRUE(old);
  EXPECT_TRUE(old->fix.valid);
  EXPECT_TRUE(old->has_date);
  EXPECT_NEAR(old->fix.latitude, (37 + 8.5809 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(old->fix.longitude, -(121 + 39.7813 / 60) * kDegree, 1e-12);
  EXPECT_NEAR(old->fix.speed, 28.8 * 1852 / 3600, 1e-12);
  EXPECT_NEAR(old->fix.course, 158.3 * kDegree, 1e-12);
  EXPECT_TRUE(std::isnan(old->fix.altitude));
  EXPECT_TRUE(std::isnan(old->fix.hdop));
  EXPECT_EQ(old->fix.utc_ns, 1'355'263'363'000'000'000);  // 2012-12-11 22:02:43

  const auto fractional = parse_nmea(
      "$GPRMC,081802.00,A,3649.7478558,N,00224.4542928,W,0.034,212.5,210116,0.0,E,A*2E\r\n");
  ASSERT_TRUE(fractional);
  EXPECT_NEAR(fractional->fix.longitude, -(2 + 24.4542928 / 60) * kDegree, 1e-14);
  EXPECT_EQ(fractional->fix.utc_ns, 1'453'364'282'000'000'000);  // 2016-01-21 08:18:02
}

TEST(Nmea, ParsesBothTypesOfAnyTalker) {
  for (const char* talker : {"GP", "GN", "GL", "BD", "GA"}) {
    fixtures::NmeaFields sent;
    sent.talker = talker;
    sent.utc_ns = 1'700'000'000'120'000'000;
    sent.latitude = -0.61;
    sent.longitude = 2.6;
    sent.altitude = 57.25;
    sent.hdop = 1.2;
    sent.speed = 13.2;
    sent.course = 4.1;
    const auto rmc = parse_nmea(fixtures::rmc_sentence(sent));
    ASSERT_TRUE(rmc) << describe(rmc.error());
    EXPECT_NEAR(rmc->fix.latitude, sent.latitude, 1e-10);
    EXPECT_NEAR(rmc->fix.longitude, sent.longitude, 1e-10);
    EXPECT_NEAR(rmc->fix.speed, sent.speed, 3e-4);
    EXPECT_NEAR(rmc->fix.course, sent.course, 1e-4);
    EXPECT_EQ(rmc->fix.utc_ns, sent.utc_ns);
    const auto gga = parse_nmea(fixtures::gga_sentence(sent));
    ASSERT_TRUE(gga) << describe(gga.error());
    EXPECT_FALSE(gga->has_date);
    EXPECT_NEAR(gga->fix.altitude, 57.25, 1e-9);
    EXPECT_NEAR(gga->fix.hdop, 1.2, 1e-9);
    EXPECT_TRUE(std::isnan(gga->fix.speed));
    EXPECT_EQ(gga->fix.utc_ns, sent.utc_ns % 86'400'000'000'000);
  }
}

TEST(Nmea, ASentenceWithoutAFixIsNotValid) {
  const auto rmc = parse_nmea(fixtures::with_checksum("$GPRMC,120000,V,,,,,,,010124,,,N"));
  ASSERT_TRUE(rmc);
  EXPECT_FALSE(rmc->fix.valid);
  EXPECT_TRUE(std::isnan(rmc->fix.speed));
  const auto gga = parse_nmea(fixtures::with_checksum("$GPGGA,120000,,,,,0,00,,,M,,M,,"));
  ASSERT_TRUE(gga);
  EXPECT_FALSE(gga->fix.valid);
  EXPECT_TRUE(std::isnan(gga->fix.altitude));
}

TEST(Nmea, ReportsFaults) {
  const auto fault = [](std::string text) {
    const auto fix = parse_nmea(text);
    return fix ? std::string("none") : std::string(describe(fix.error()));
  };
  const auto fault_of = [&](const std::string& body) {
    return fault(fixtures::with_checksum(body));
  };
  const std::string good = "$GPRMC,120000,A,4807.038,N,01131.000,E,0.0,0.0,010124,,,A";
  EXPECT_EQ(fault_of(good), "none");
  EXPECT_EQ(fault(""), describe(NmeaFault::kNoSentence));
  EXPECT_EQ(fault(good), describe(NmeaFault::kNoSentence));  // no checksum
  EXPECT_EQ(fault(good + "*00"), describe(NmeaFault::kChecksum));
  EXPECT_EQ(fault(good + "*"), describe(NmeaFault::kChecksum));
  std::string behind_nul = fixtures::with_checksum(good);
  behind_nul.insert(behind_nul.begin(), char{0});
  EXPECT_EQ(fault(behind_nul), describe(NmeaFault::kNoSentence));
  EXPECT_EQ(fault_of("$GPGSV,1,1,00"), describe(NmeaFault::kType));
  EXPECT_EQ(fault_of("$RMC,120000,A"), describe(NmeaFault::kType));
  for (const char* body : {
           "$GPRMC,120000,A,4807.038,N,01131.000,E,0.0,0.0,310224,,,A",  // 31 February
           "$GPRMC,250000,A,4807.038,N,01131.000,E,0.0,0.0,010124,,,A",  // hour 25
           "$GPRMC,120000,A,9907.038,N,01131.000,E,0.0,0.0,010124,,,A",  // latitude 99°
           "$GPRMC,120000,A,4867.038,N,01131.000,E,0.0,0.0,010124,,,A",  // minute 67
           "$GPRMC,120000,A,4807.038,X,01131.000,E,0.0,0.0,010124,,,A",  // hemisphere X
           "$GPRMC,120000,A,nan,N,01131.000,E,0.0,0.0,010124,,,A",
           "$GPRMC,120000,A,1e999,N,01131.000,E,0.0,0.0,010124,,,A",
           "$GPRMC,120000,A",
           "$GPRMC,1e9999,A,4807.038,N,01131.000,E,0.0,0.0,010124,,,A",
           "$GPGGA,120000,4807.038,N,01131.000,E,x,08,0.9,545.4,M,46.9,M,,",
       }) {
    EXPECT_EQ(fault_of(body), describe(NmeaFault::kField)) << body;
  }
}

}  // namespace
}  // namespace infuse::gnss
