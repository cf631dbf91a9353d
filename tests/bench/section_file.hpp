#pragma once

#include <fstream>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace infuse::bench {

/// Section of a generated document that can be regenerated separately.
struct Section {
  std::string name;   ///< name on the command line
  std::string title;  ///< heading
  int runs;           ///< default number of random repetitions
  /// Writes the text below the heading; returns false on failure.
  std::function<bool(std::ostream&, int runs)> write;
};

/// Reads the sections of a Markdown file with their headings, by title; the text before the first
/// is omitted.
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

/// Regenerates `section` in the file at `path`: `preamble`, then all sections of `order` that
/// exist, the others unchanged. Returns true on success.
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
