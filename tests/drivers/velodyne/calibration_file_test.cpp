#include "drivers/velodyne/calibration_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "fixtures/velodyne/db_xml.hpp"

namespace infuse::velodyne {
namespace {

void expect_same(const Calibration& a, const Calibration& b, double tolerance) {
  for (size_t laser = 0; laser < 64; ++laser) {
    const BeamCorrection& p = a.beams[laser];
    const BeamCorrection& q = b.beams[laser];
    EXPECT_NEAR(p.elevation, q.elevation, tolerance);
    EXPECT_NEAR(p.rotation, q.rotation, tolerance);
    EXPECT_NEAR(p.distance, q.distance, tolerance);
    EXPECT_NEAR(p.distance_x, q.distance_x, tolerance);
    EXPECT_NEAR(p.distance_y, q.distance_y, tolerance);
    EXPECT_NEAR(p.vertical_offset, q.vertical_offset, tolerance);
    EXPECT_NEAR(p.horizontal_offset, q.horizontal_offset, tolerance);
    EXPECT_NEAR(p.focal_distance, q.focal_distance, tolerance);
    EXPECT_NEAR(p.focal_slope, q.focal_slope, tolerance);
    EXPECT_EQ(p.min_intensity, q.min_intensity);
    EXPECT_EQ(p.max_intensity, q.max_intensity);
  }
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), with);
}

TEST(CalibrationFile, ReadsDbXmlInItsUnits) {
  // Laser 1 as in a file, in degrees and centimetres.
  std::string text = write_db_xml(built_in_calibration(Model::kHdl64eS2));
  const size_t begin = text.find("<id_>1</id_>");
  const size_t end = text.find("</px>", begin);
  text.replace(begin, end - begin,
               "<id_>1</id_><rotCorrection_>-3.5</rotCorrection_>"
               "<vertCorrection_>-8.25</vertCorrection_><distCorrection_>151.5</distCorrection_>"
               "<distCorrectionX_>152</distCorrectionX_><distCorrectionY_>153</distCorrectionY_>"
               "<vertOffsetCorrection_>19.5</vertOffsetCorrection_>"
               "<horizOffsetCorrection_>-2.6</horizOffsetCorrection_>"
               "<focalDistance_>1200</focalDistance_><focalSlope_>1.4</focalSlope_>");
  const auto calibration = parse_db_xml(text);
  ASSERT_TRUE(calibration) << calibration.error().message();
  const BeamCorrection& beam = calibration->beams[1];
  EXPECT_NEAR(beam.rotation, -0.0610865, 1e-7);
  EXPECT_NEAR(beam.elevation, -0.1439897, 1e-7);
  EXPECT_DOUBLE_EQ(beam.distance, 1.515);
  EXPECT_DOUBLE_EQ(beam.distance_x, 1.52);
  EXPECT_DOUBLE_EQ(beam.distance_y, 1.53);
  EXPECT_DOUBLE_EQ(beam.vertical_offset, 0.195);
  EXPECT_NEAR(beam.horizontal_offset, -0.026, 1e-12);
  EXPECT_DOUBLE_EQ(beam.focal_distance, 12);
  EXPECT_DOUBLE_EQ(beam.focal_slope, 1.4);
  EXPECT_EQ(beam.min_intensity, 40);
}

TEST(CalibrationFile, AllLasersRoundTripThroughAFile) {
  const auto path = std::filesystem::path(testing::TempDir()) / "velodyne_db.xml";
  std::ofstream(path) << write_db_xml(built_in_calibration(Model::kHdl64eS3));
  const auto calibration = load_db_xml(path);
  ASSERT_TRUE(calibration) << calibration.error().message();
  expect_same(*calibration, built_in_calibration(Model::kHdl64eS3), 1e-12);
  std::filesystem::remove(path);
  const auto none = load_db_xml(path);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().where, path.string());
}

TEST(CalibrationFile, ErrorsNameTheirCause) {
  const std::string whole = write_db_xml(built_in_calibration(Model::kHdl64eS2));
  const auto error = [](const std::string& text) {
    const auto calibration = parse_db_xml(text);
    return calibration ? std::string("none") : calibration.error().message();
  };
  const auto mentions = [&](const std::string& text, const std::string& word) {
    EXPECT_NE(error(text).find(word), std::string::npos) << error(text);
  };
  EXPECT_EQ(error(whole), "none");
  EXPECT_EQ(error(replaced(whole, "<DB ", "<!-- <a> </b> a comment --><DB ")), "none");
  mentions("", "");
  mentions("no xml", "db.xml");
  mentions(replaced(whole, "<id_>7</id_>", "<id_>8</id_>"), "63 of 64");
  mentions(replaced(whole, "<id_>7</id_>", "<id_>64</id_>"), "63 of 64");
  mentions(replaced(whole, "<focalSlope_>", "<focalSlop_>"), "laser 0");
  mentions(replaced(replaced(whole, "<focalSlope_>", "<slope>"), "</focalSlope_>", "</slope>"),
           "laser 0");
  mentions(replaced(whole, "<rotCorrection_>", "<rotCorrection_>1e9"), "laser 0");
  mentions(whole.substr(0, whole.size() / 2), "db.xml");
  mentions(std::string(5 << 20, ' '), "4 MiB");
}

// The XML parser recurses: a million levels must not reach it, however they are disguised.
TEST(CalibrationFile, BoundsTheDepth) {
  const auto deep = [](const std::string& opening) {
    std::string text;
    for (int i = 0; i < 300'000 / static_cast<int>(opening.size()) * 3; ++i) text += opening;
    return text;
  };
  for (const char* opening :
       {"<a>", "<a b='/>'>", "<a b=\"'\" c='/>'>", "<a b='</a>'>", "<a><!--</a>-->", "<a></ >",
        "<a><?x </a>?>", "<a><![CDATA[</a>]]>", "<a><!DOCTYPE x [</a>]>"}) {
    EXPECT_FALSE(parse_db_xml(deep(opening))) << opening;
  }
}

}  // namespace
}  // namespace infuse::velodyne
