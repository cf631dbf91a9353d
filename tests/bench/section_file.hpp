#pragma once

#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace infuse::bench {

/// A part of a generated document that can be made by itself.
struct Section {
  std::string name;   ///< by which it is requested
  std::string title;  ///< its heading
  int runs;           ///< how often what is random is repeated, unless asked otherwise
  /// Writes what stands below the heading; false where it could not be made.
  std::function<bool(std::ostream&, int runs)> write;
};

/// The sections of a Markdown file, each with its heading, by title; what comes before the first is
/// left out.
inline std::map<std::string, std::string> read_sections(const std::string& path) {
  std::map<std::string, std::string> sections;
  std::ifstream file(path);
  std::string line, title;
  while (std::getline(file, line)) {
    if (line.starts_with("## ")) title = line.substr(3);
    if (!title.empty()) sections[title] += line + "\n";
  }
  return sections;
}

/// Makes `section` anew in the file at `path`: `head`, then all sections of `order` that have been
/// made, the others as they are. Whether it could be made and written.
inline bool rewrite_section(const std::string& path, const std::string& preamble,
                            const std::vector<Section>& order, const Section& section, int runs) {
  std::ostringstream section_text;
  section_text << "## " << section.title << "\n\n";
  if (!section.write(section_text, runs)) return false;
  auto all = read_sections(path);
  all[section.title] = section_text.str();
  std::ofstream file(path);
  file << preamble;
  for (const Section& one : order) {
    std::string text = all[one.title];
    while (text.ends_with("\n\n")) text.pop_back();
    if (!text.empty()) file << "\n" << text;
  }
  file.close();
  return file.good();
}

}  // namespace infuse::bench
