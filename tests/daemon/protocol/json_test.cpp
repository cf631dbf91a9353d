#include "daemon/protocol/json.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

TEST(JsonText, ReplacesTextThatIsNotUtf8) {
  EXPECT_EQ(json_text({{"name", "caf\xC3\xA9"}}), "{\"name\":\"caf\xC3\xA9\"}");
  EXPECT_EQ(json_text({{"name", "caf\xE9"}}), "{\"name\":\"caf\xEF\xBF\xBD\"}");
}

}  // namespace
}  // namespace infuse::daemon
