#include "daemon/view/access.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

constexpr const char* kToken = "0123456789abcdef-XY";

ViewSettings with_token() {
  ViewSettings settings;
  settings.token = kToken;
  return settings;
}

int status_of(const ViewRequest& request, const ViewSettings& settings = {}) {
  const auto refused = check_access(request, settings);
  return refused ? refused->status : 200;
}

ViewRequest get(std::string_view target, std::string_view host = "127.0.0.1:9468") {
  return {.method = "GET", .target = target, .host = host};
}

TEST(ViewAccess, ReadsFromThisHostAreAllowed) {
  for (const char* host :
       {"127.0.0.1:9468", "localhost:9468", "localhost", "[::1]:9468", "10.0.0.7:9468"}) {
    EXPECT_EQ(status_of(get("/", host)), 200) << host;
  }
  ViewRequest page = get("/stream");
  page.origin = "http://127.0.0.1:9468";
  page.upgrade = true;
  EXPECT_EQ(status_of(page), 200);
}

TEST(ViewAccess, WritesAreRefused) {
  for (const char* method : {"POST", "PUT", "DELETE", "OPTIONS", "TRACE", "CONNECT", "get", ""}) {
    ViewRequest request = get("/");
    request.method = method;
    EXPECT_EQ(status_of(request), 405) << method;
  }
}

TEST(ViewAccess, NamesThatMayBeReboundAreRefused) {
  for (const char* host :
       {"evil.example", "evil.example:9468", "localhost.evil.example", "127.0.0.1.evil.example", "",
        "localhost:evil", "[::1", "127.0.0.1:9468:1", "localhost@evil.example"}) {
    EXPECT_EQ(status_of(get("/", host)), 403) << host;
  }
  ViewRequest twice = get("/");
  twice.hosts = 2;
  EXPECT_EQ(status_of(twice), 400);
  twice.hosts = 0;
  EXPECT_EQ(status_of(twice), 400);
  EXPECT_EQ(status_of(get("/", std::string(300, '1'))), 403);
}

TEST(ViewAccess, PagesOfOthersAreRefused) {
  for (const char* origin :
       {"http://evil.example", "null", "https://127.0.0.1:9468", "http://127.0.0.1:80",
        "http://localhost:9468", "http://127.0.0.1:9468.evil.example", "file://"}) {
    ViewRequest request = get("/stream");
    request.origin = origin;
    EXPECT_EQ(status_of(request), 403) << origin;
  }
  ViewSettings settings;
  settings.allowed_origins = {"http://studio.example:8080"};
  ViewRequest request = get("/stream");
  request.origin = "http://studio.example:8080";
  EXPECT_EQ(status_of(request, settings), 200);
  request.origin = "http://studio.example";
  EXPECT_EQ(status_of(request, settings), 403);
}

TEST(ViewAccess, WithATokenNothingIsReadWithoutIt) {
  const ViewSettings settings = with_token();
  EXPECT_EQ(status_of(get("/"), settings), 401);
  EXPECT_EQ(status_of(get("/?token="), settings), 401);
  EXPECT_EQ(status_of(get("/?token=0123456789abcdef-X"), settings), 401);
  EXPECT_EQ(status_of(get("/?token=0123456789abcdef-XYZ"), settings), 401);
  EXPECT_EQ(status_of(get("/?xtoken=0123456789abcdef-XY"), settings), 401);
  EXPECT_EQ(status_of(get("/?token=0123456789abcdef-XY"), settings), 200);
  EXPECT_EQ(status_of(get("/?a=b&token=0123456789abcdef-XY"), settings), 200);
  ViewRequest request = get("/stream");
  for (const auto& [cookie, status] : {std::pair("infuse_view=0123456789abcdef-XY", 200),
                                       {"a=b; infuse_view=0123456789abcdef-XY", 200},
                                       {"xinfuse_view=0123456789abcdef-XY", 401},
                                       {"infuse_view=", 401},
                                       {"infuse_view", 401},
                                       {";;;", 401}}) {
    request.cookie = cookie;
    EXPECT_EQ(status_of(request, settings), status) << cookie;
  }
}

TEST(ViewAccess, TargetsAreBoundedPaths) {
  EXPECT_EQ(status_of(get("")), 400);
  EXPECT_EQ(status_of(get("http://127.0.0.1/")), 400);
  EXPECT_EQ(status_of(get("*")), 400);
  EXPECT_EQ(status_of(get("/" + std::string(2000, 'a'))), 400);
  EXPECT_EQ(path_of("/style.css?v=1"), "/style.css");
  EXPECT_EQ(path_of("/"), "/");
}

TEST(ViewSettings, BeyondTheLoopbackATokenIsNeeded) {
  ViewSettings settings;
  EXPECT_FALSE(settings.invalid());
  settings.bind = "0.0.0.0";
  EXPECT_TRUE(settings.invalid());
  settings.token = "short";
  EXPECT_TRUE(settings.invalid());
  settings.token = kToken;
  EXPECT_FALSE(settings.invalid());
  settings.token = "0123456789abcdef;x=y";
  EXPECT_TRUE(settings.invalid());
  settings = {};
  settings.bind = "localhost";
  EXPECT_TRUE(settings.invalid());
  settings = {};
  settings.max_clients = 0;
  EXPECT_TRUE(settings.invalid());
  settings = {};
  settings.allowed_origins = {"studio.example"};
  EXPECT_TRUE(settings.invalid());
}

}  // namespace
}  // namespace infuse::daemon
