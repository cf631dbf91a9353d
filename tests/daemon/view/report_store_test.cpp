#include "daemon/view/report_store.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace infuse::daemon {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

TEST(ReportStore, KeepsAlertsAndThinsTheRestWithinItsBytes) {
  ReportStore store(4000);
  for (int i = 0; i < 1000; ++i) {
    const bool alert = i % 250 == 0;
    store.add(alert ? ReportClass::kAlert : ReportClass::kHealth,
              (alert ? "alert " : "health ") + std::to_string(i));
  }
  const std::string text = store.text();
  EXPECT_LE(text.size(), 4500u);
  for (const char* kept : {"alert 0\n", "alert 250\n", "alert 500\n", "alert 750\n"}) {
    EXPECT_THAT(text, HasSubstr(kept));
  }
  EXPECT_THAT(text, EndsWith("health 998\nhealth 999"));
  int last = -1;  // in their order
  std::istringstream lines(text);
  for (std::string name, number; lines >> name >> number; last = std::stoi(number)) {
    EXPECT_GT(std::stoi(number), last);
  }
}

TEST(ReportStore, ManyAlertsDoNotGrowIt) {
  ReportStore store(1000);
  for (int i = 0; i < 1000; ++i) store.add(ReportClass::kAlert, "alert " + std::to_string(i));
  EXPECT_LE(store.text().size(), 1200u);  // with its line feeds
  EXPECT_THAT(store.text(), EndsWith("alert 999"));
}

}  // namespace
}  // namespace infuse::daemon
