#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/version.hpp"
#include "daemon/owner/client.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/run_program.hpp"
#include "daemon/owner/support_bundle.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

namespace fs = std::filesystem;

struct DiagnoseArguments {
  std::string output;
  std::string config = "/etc/infuse/infused.toml";
  std::string state = "/var/lib/infuse";
  std::string socket;
};

/// The files of a folder with one of these endings, by name; none if it cannot be read.
std::vector<fs::path> files_of(const fs::path& folder, std::initializer_list<const char*> endings) {
  std::vector<fs::path> files;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (std::any_of(endings.begin(), endings.end(),
                    [&](const char* ending) { return name.ends_with(ending); })) {
      files.push_back(entry->path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// A text, or why there is none.
std::string text_or_reason(const fs::path& file) {
  constexpr size_t kMaxAddedBytes = size_t{64} << 20;
  const auto text = text::read_text(file, kMaxAddedBytes);
  return text ? *text : text.error().message() + "\n";
}

void add_configuration(const DiagnoseArguments& arguments, SupportBundle& bundle) {
  const fs::path config(arguments.config);
  std::vector<fs::path> files = files_of(config.parent_path(), {".toml", ".dbc"});
  const auto drop_ins = files_of(arguments.config + ".d", {".toml"});
  files.insert(files.end(), drop_ins.begin(), drop_ins.end());
  if (std::find(files.begin(), files.end(), config) == files.end()) files.push_back(config);
  for (const fs::path& file : files) bundle.hide_secrets_of(text_or_reason(file));
  for (const fs::path& file : files) {
    bundle.add("config/" + file.lexically_relative(config.parent_path()).string(),
               text_or_reason(file));
  }
  bundle.add(
      "check_config.json",
      run_program({"infused", "--check-config", "--json", "--config", arguments.config}).output);
}

/// The last report of every class, and the greeting.
std::string reports_of(const std::string& socket) {
  auto client = Client::connect(socket);
  if (!client) return client.error().message() + "\n";
  std::string lines = json_text(client->version()) + "\n";
  if (!client->send({{"op", "poll"}})) return lines;
  for (;;) {
    const auto message = client->next(std::chrono::seconds(5));
    if (!message || !*message || (*message)->value("class", "") == "ACK") return lines;
    lines += json_text(**message) + "\n";
  }
}

void add_host(SupportBundle& bundle) {
  const std::pair<const char*, std::vector<std::string>> questions[] = {
      {"infused_version.txt", {"infused", "--version"}},
      {"kernel.txt", {"uname", "-a"}},
      {"packages.txt", {"dpkg-query", "--list", "infuse*", "libinfuse*"}},
      {"unit.txt", {"systemctl", "cat", "infused.service", "infused.socket", "--no-pager"}},
      {"unit_status.txt", {"systemctl", "status", "infused.service", "--no-pager", "--lines=0"}},
      {"journal.txt",
       {"journalctl", "--unit=infused", "--lines=20000", "--output=short-iso", "--no-pager"}},
      {"disks.txt", {"df", "-h"}},
      {"interfaces.txt", {"ip", "-statistics", "address"}},
      {"clock.txt", {"timedatectl", "show", "--no-pager"}},
      {"chrony.txt", {"chronyc", "-n", "tracking"}}};
  for (const auto& [name, words] : questions) bundle.add(name, run_program(words).output);
  bundle.add("os_release.txt", text_or_reason("/etc/os-release"));
}

int run(const DiagnoseArguments& arguments) {
  SupportBundle bundle;
  bundle.add("infuse_version.txt", std::string(version()) + "\n");
  add_configuration(arguments, bundle);
  bundle.add("reports.jsonl", reports_of(arguments.socket));
  for (const fs::path& file : files_of(arguments.state, {".json", ".jsonl", ".jsonl.1", ".txt"})) {
    bundle.add("state/" + file.filename().string(), text_or_reason(file));
  }
  add_host(bundle);
  if (const auto written = bundle.write(arguments.output); !written) {
    return print_error("infuse diagnose", written.error(), kFailure);
  }
  std::cout << fmt::format("{}: {} files; it holds positions and names of this vehicle\n",
                           arguments.output, bundle.size());
  return kDone;
}

}  // namespace

Command declare_diagnose(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "diagnose",
      "collect what support asks for: configuration without secrets, versions, reports, history, "
      "crash notes, journal");
  const auto arguments = std::make_shared<DiagnoseArguments>();
  app->add_option("-o,--output", arguments->output, "archive to write (tar, zstd)")
      ->type_name("FILE.tar.zst")
      ->required();
  app->add_option("--config", arguments->config,
                  "configuration of the daemon (/etc/infuse/infused.toml)")
      ->type_name("PATH");
  app->add_option("--state", arguments->state, "state directory of the daemon (/var/lib/infuse)")
      ->type_name("DIR");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  set_examples(*app, {"infuse diagnose -o vehicle7.tar.zst",
                      "infuse diagnose -o v.tar.zst --config vehicle.toml --state state/"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
