#include "daemon/pages/report_page.hpp"

#include "daemon/pages/page_files.hpp"  // made by cmake from daemon/pages/page
#include "daemon/pages/page_style.hpp"

namespace infuse::daemon {
namespace {

/// JSON that can stand in a <script> element: no tag can end or begin in it.
std::string script_text(const Json& data) {
  std::string out;
  for (const char c : json_text(data)) {
    if (c == '<') {
      out += "\\u003c";
    } else {
      out += c;
    }
  }
  return out;
}

}  // namespace

const char* page_style() { return kPageStyle; }

std::string make_report_page(const Json& data) {
  return std::string(
             "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
             "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
             "img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
             "<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n") +
         kPageStyle + "</style></head>\n" + kPageBody +
         "<script type=\"application/json\" id=\"data\">" + script_text(data) +
         "</script>\n<script>\n" + kPageCharts + kPageCode + "</script></html>\n";
}

}  // namespace infuse::daemon
