// bench-report: merges the results of several Google Benchmark files into one list. A benchmark
// named `X` is compared with every `X/baseline:WHO` of the same run; a ratio above 1 means that X
// is better.
//
// bench-report OUT.json IN.json...       OUT "-": prints the table only

#include <cstdio>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace {

using Json = nlohmann::ordered_json;

/// Result of one benchmark: a rate (higher is better) or a time (lower is better).
struct Figure {
  double value = 0;
  std::string unit;
  bool is_rate = false;
};

/// Removes the suffixes that Google Benchmark adds to a name.
std::string without_modifiers(std::string name) {
  for (const char* modifier : {"/real_time", "/process_time", "/manual_time",
                               "/iterations:", "/min_time:", "/repeats:", "/threads:"}) {
    const size_t begin = name.find(modifier);
    if (begin == std::string::npos) continue;
    const size_t end = name.find('/', begin + 1);
    name.erase(begin, end == std::string::npos ? end : end - begin);
  }
  return name;
}

Figure parse_figure(const Json& run) {
  if (run.contains("items_per_second")) {
    return {run["items_per_second"], run.value("label", "1/s"), true};
  }
  return {run.value("real_time", 0.0), run.value("time_unit", "ns"), false};
}

/// Results by name: the median of several repetitions, or the only run; in the order of the files.
struct Figures {
  std::vector<std::string> names;
  std::map<std::string, Figure> by_name;

  void read(const Json& file) {
    for (const Json& run : file.value("benchmarks", Json::array())) {
      if (run.value("error_occurred", false)) continue;
      const bool aggregate = run.value("run_type", "") == "aggregate";
      if (aggregate && run.value("aggregate_name", "") != "median") continue;
      const std::string name = without_modifiers(run.value("run_name", ""));
      if (!by_name.contains(name)) names.push_back(name);
      by_name[name] = parse_figure(run);
    }
  }
};

/// Splits "decode/x/baseline:pcl/8" into the benchmark "decode/x/8" and the baseline "pcl".
struct Baseline {
  std::string benchmark, name;
};
std::optional<Baseline> parse_baseline(const std::string& name) {
  constexpr std::string_view kBaselineMark = "/baseline:";
  const size_t begin = name.find(kBaselineMark);
  if (begin == std::string::npos) return std::nullopt;
  const size_t end = std::min(name.find('/', begin + 1), name.size());
  const size_t who = begin + kBaselineMark.size();
  return Baseline{name.substr(0, begin) + name.substr(end), name.substr(who, end - who)};
}

Json make_entry(const std::string& name, const Figure& figure) {
  return {{"name", name}, {"value", figure.value}, {"unit", figure.unit}};
}

Json make_comparison(const std::string& name, const Figure& figure,
                     const std::string& baseline_name, const Figure& other) {
  Json json = make_entry(name, figure);
  json["baseline"] = baseline_name;
  json["baseline_value"] = other.value;
  json["ratio"] = figure.is_rate ? figure.value / other.value : other.value / figure.value;
  return json;
}

Json make_list(const Figures& figures) {
  Json list = Json::array();
  for (const std::string& name : figures.names) {
    if (parse_baseline(name)) continue;
    const Figure& figure = figures.by_name.at(name);
    bool has_baseline = false;
    for (const std::string& other : figures.names) {
      const auto its = parse_baseline(other);
      if (!its || its->benchmark != name) continue;
      list.push_back(make_comparison(name, figure, its->name, figures.by_name.at(other)));
      has_baseline = true;
    }
    if (!has_baseline) list.push_back(make_entry(name, figure));
  }
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: bench-report OUT.json|- IN.json...\n";
    return 2;
  }
  Figures figures;
  for (int i = 2; i < argc; ++i) {
    std::ifstream stream(argv[i]);
    const Json file = Json::parse(stream, nullptr, false);
    if (file.is_object()) figures.read(file);
  }
  const Json list = make_list(figures);
  for (const Json& row : list) {
    std::printf("%-44s %12.4g %-16s", row["name"].get<std::string>().c_str(),
                row["value"].get<double>(), row["unit"].get<std::string>().c_str());
    if (row.contains("ratio")) {
      std::printf(" %8.2f × %s (%.4g)", row["ratio"].get<double>(),
                  row["baseline"].get<std::string>().c_str(), row["baseline_value"].get<double>());
    }
    std::printf("\n");
  }
  if (std::string(argv[1]) == "-") return 0;
  std::ofstream out(argv[1]);
  out << list.dump(2) << "\n";
  return out ? 0 : 1;
}
