#include "daemon/owner/installed_tools.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "daemon/command_line/arguments.hpp"
#include "daemon/command_line/tool.hpp"

namespace infuse::daemon {
namespace {

constexpr const char* kToolsPackage = "infuse-tools";
const std::string kToolPrefix = "infuse-";

int run_instead(const std::filesystem::path& program, int argc, char** argv) {
  std::vector<char*> arguments(argv + 1, argv + argc);
  std::string path = program.string();
  arguments.front() = path.data();
  arguments.push_back(nullptr);
  ::execv(path.c_str(), arguments.data());
  return print_error("infuse", {std::string("cannot be run: ") + std::strerror(errno), path, ""},
                     kUsage);
}

/// Lists the tools in the help, and the package of those that are missing.
void describe_tools(CLI::App& infuse, const std::set<std::string>& installed) {
  std::string missing;
  for (const Tool& tool : kTools) {
    if (!installed.contains(tool.name))
      missing += std::string(missing.empty() ? "" : ", ") + tool.name;
  }
  for (const std::string& name : installed) {
    const Tool* known = find_tool(name);
    (known != nullptr ? add_tool(infuse, *known) : infuse.add_subcommand(name))->group("Tools");
  }
  if (missing.empty()) return;
  infuse.footer("Not installed (package " + std::string(kToolsPackage) + "): " + missing + "\n\n" +
                infuse.get_footer());
}

}  // namespace

std::filesystem::path tools_folder() {
  if (const char* folder = std::getenv("INFUSE_EXEC_PATH")) return folder;
  std::error_code error;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "libexec/infuse";
}

std::set<std::string> installed_tools(const std::filesystem::path& folder) {
  std::set<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with(kToolPrefix) || ::access(entry.path().c_str(), X_OK) != 0) continue;
    names.insert(name.substr(kToolPrefix.size()));
  }
  return names;
}

std::optional<int> start_tool(CLI::App& infuse, int argc, char** argv) {
  const auto folder = tools_folder();
  const auto installed = installed_tools(folder);
  const std::string name = argc > 1 ? argv[1] : "";
  const auto is_named = [&](const CLI::App* command) { return command->get_name() == name; };
  if (infuse.get_subcommands(is_named).empty()) {
    if (installed.contains(name)) return run_instead(folder / (kToolPrefix + name), argc, argv);
    if (find_tool(name) != nullptr) {
      return print_error("infuse",
                         {"'" + name + "' is not installed", "",
                          std::string("it is in the package ") + kToolsPackage},
                         kUsage);
    }
  }
  describe_tools(infuse, installed);
  return std::nullopt;
}

}  // namespace infuse::daemon
