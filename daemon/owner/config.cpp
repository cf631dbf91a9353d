#include <spdlog/fmt/fmt.h>

#include <filesystem>
#include <iostream>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/owner/commands.hpp"
#include "daemon/owner/config_trial.hpp"
#include "daemon/owner/readiness.hpp"
#include "daemon/owner/report_text.hpp"
#include "daemon/owner/run_program.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kConfigProgram = "infuse config";
constexpr int kNotFound = 127;  // exit code of a program that is not there, as shells have it

struct ConfigArguments {
  std::string action;
  std::string file;
  std::string target = "/etc/infuse/infused.toml";
  std::string socket;
  std::string restart = "systemctl restart infused.service";
  double wait_s = 60;
  bool json = false;
};

std::vector<std::string> words_of(const std::string& command) {
  std::istringstream stream(command);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

/// The daemon's own check of a configuration: that of PATH, or else the one beside this program.
ProgramEnd run_check(const std::string& file, bool json) {
  std::vector<std::string> words = {"infused", "--check-config", "--config", file};
  if (json) words.emplace_back("--json");
  ProgramEnd end = run_program(words);
  if (end.code != kNotFound) return end;
  std::error_code failed;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", failed);
  words.front() = (program.parent_path() / "infused").string();
  return run_program(words);
}

/// The same as one JSON object.
Result<Json> ask_daemon(const std::string& file) {
  const ProgramEnd end = run_check(file, true);
  Json checked = Json::parse(end.output, nullptr, false);
  if (checked.is_object()) return checked;
  return fail("infused --check-config cannot be run: " + end.output, file,
              "is the package infused installed?");
}

Result<void> restart_daemon(const ConfigArguments& arguments) {
  const ProgramEnd end = run_program(words_of(arguments.restart));
  if (end.code == 0) return {};
  return fail(fmt::format("'{}' failed: {}", arguments.restart, end.output));
}

/// Restarts the daemon with the configuration that is in place. Nothing if it is ready in time,
/// else why it is not.
std::optional<Error> try_in_place(const ConfigArguments& arguments, std::string& digest) {
  const auto checked = ask_daemon(arguments.target);
  if (!checked) return checked.error();
  if (!checked->value("valid", false)) {
    const Json wrong = checked->value("error", Json::object());
    return Error{text_of(wrong, "what"), text_of(wrong, "where"), text_of(wrong, "hint")};
  }
  digest = text_of(*checked, "config_digest");
  if (auto restarted = restart_daemon(arguments); !restarted) return restarted.error();
  const auto missing = wait_until_ready(arguments.socket, arguments.wait_s, digest);
  if (!missing) return std::nullopt;
  return Error{fmt::format("not ready after {} s: waits for {}", arguments.wait_s, *missing),
               arguments.file, ""};
}

int apply(const ConfigArguments& arguments) {
  constexpr size_t kMaxNewBytes = 1 << 20;
  const auto text = text::read_text(arguments.file, kMaxNewBytes);
  if (!text) return print_error(kConfigProgram, text.error(), kUnreadable);
  const ConfigTrial trial(arguments.target);
  if (const auto begun = trial.begin(*text); !begun) {
    return print_error(kConfigProgram, begun.error(), kFailure);
  }
  std::string digest;
  const auto wrong = try_in_place(arguments, digest);
  if (!wrong) {
    if (const auto kept = trial.confirm(); !kept) {
      return print_error(kConfigProgram, kept.error(), kFailure);
    }
    std::cout << fmt::format("{}: configuration {} is in use\n", arguments.target, digest);
    return kDone;
  }
  print_error(kConfigProgram, *wrong, kFailure);
  if (const auto back = trial.restore(); !back) {
    return print_error(kConfigProgram, back.error(), kFailure);
  }
  // Where it was found wrong before a restart, the daemon runs on with the one before.
  if (!digest.empty()) {
    if (const auto restarted = restart_daemon(arguments); !restarted) {
      return print_error(kConfigProgram, restarted.error(), kFailure);
    }
  }
  std::cerr << kConfigProgram << ": the configuration before it is in use\n";
  return digest.empty() ? kUsage : kFailure;
}

int check(const ConfigArguments& arguments) {
  const ProgramEnd end =
      run_check(arguments.file.empty() ? arguments.target : arguments.file, arguments.json);
  if (end.code == kNotFound) {
    return print_error(kConfigProgram,
                       {"infused is not there", "", "is the package infused installed?"}, kFailure);
  }
  std::cout << end.output;
  return end.code;
}

int settle(const ConfigArguments& arguments) {
  const auto settled = ConfigTrial(arguments.target).settle();
  if (!settled) return print_error(kConfigProgram, settled.error(), kFailure);
  if (*settled) {
    std::cout << arguments.target
              << ": a configuration was not confirmed; the one before is back\n";
  }
  return kDone;
}

int run(const ConfigArguments& arguments) {
  if (arguments.action == "check") return check(arguments);
  if (arguments.action == "settle") return settle(arguments);
  if (!arguments.file.empty()) return apply(arguments);
  return print_error(kConfigProgram, {"no configuration to apply", "", "name a FILE"}, kUsage);
}

}  // namespace

Command declare_config(CLI::App& infuse) {
  CLI::App* app = infuse.add_subcommand(
      "config",
      "check a configuration; apply one, and take it back if the daemon is not ready in time "
      "(exit code 1)");
  const auto arguments = std::make_shared<ConfigArguments>();
  app->add_option("ACTION", arguments->action,
                  "check FILE; apply FILE; settle: take back what was applied and not confirmed")
      ->required()
      ->check(CLI::IsMember({"check", "apply", "settle"}));
  app->add_option("FILE", arguments->file, "configuration (TOML)");
  app->add_option("--wait", arguments->wait_s, "apply: time until the daemon must be ready, s (60)")
      ->type_name("S")
      ->check(CLI::Range(0.0, 86400.0));
  app->add_option("--target", arguments->target,
                  "configuration of the daemon (/etc/infuse/infused.toml)")
      ->type_name("PATH");
  app->add_option("--restart", arguments->restart,
                  "apply: command that restarts the daemon (systemctl restart infused.service)")
      ->type_name("COMMAND");
  app->add_option("--socket", arguments->socket, "socket of the daemon")->type_name("PATH");
  app->add_flag("--json", arguments->json, "check: print one JSON object");
  set_examples(*app, {"infuse config check new.toml", "infuse config apply new.toml --wait 60"});
  return {app, [arguments] { return run(*arguments); }};
}

}  // namespace infuse::daemon
