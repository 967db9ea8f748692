// Puts measurements of several camouflages beside each other, in one table.

#include "shell/comparison/comparison_page.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  std::string output;
  ComparisonWords words{"table", "Camouflages beside each other"};
  std::vector<std::string> rows;
};

void describe(CLI::App& app, Options& options) {
  app.add_option("rows", options.rows,
                 "NAME=FOLDER,FOLDER...: a row of the table, with the folders that evaluate --protocol has "
                 "written, one for each seed or detector; without NAME= the row has the first folder's name");
  app.add_option("--output", options.output,
                 "folder for NAME.csv, .json, .md, .tex and .svg, and index.html, a page over all tables "
                 "there");
  app.add_option("--name", options.words.name, "name of the files");
  app.add_option("--title", options.words.title, "title of the table");
  app.add_option("--note", options.words.notes, "sentences under the table");
  app.add_option("--command", options.words.command, "command that makes the table, to be shown with it");
}

/// A row of the command line.
struct NamedFolders {
  std::string name;
  std::vector<std::string> folders;
};

NamedFolders named_folders(const std::string& row) {
  const std::size_t equals = row.find('=');
  NamedFolders named{row.substr(0, equals), {}};
  for (std::size_t begin = equals + 1; begin <= row.size();) {  // from 0 without a name
    const std::size_t end = std::min(row.find(',', begin), row.size());
    named.folders.push_back(row.substr(begin, end - begin));
    begin = end + 1;
  }
  for (auto& folder : named.folders) folder = (io::path_of(folder) / "").parent_path().string();
  if (equals == std::string::npos) named.name = io::path_of(named.folders.front()).filename().string();
  return named;
}

/// \throws Error (usage) that names all that lacks of a command line
void require_complete(const Options& options, const std::vector<NamedFolders>& rows) {
  std::string lacks;
  const auto require = [&](bool holds, const std::string& what) {
    if (!holds) lacks += (lacks.empty() ? "" : "; ") + what;
  };
  require(!rows.empty(),
          "give a row for each camouflage: NAME=FOLDER,FOLDER..., written by evaluate --protocol");
  for (const auto& row : rows) {
    require(!row.name.empty(), "a row without a name; expected NAME=FOLDER,FOLDER...");
    for (const std::string& folder : row.folders)
      if (is_there(manifest_path(folder)) && !is_there(folder + "/settings.json"))
        require(false, folder + " is a run that is not measured yet: " +
                           shell_line({"evaluate", "--run", folder, "--protocol", "digital", "--output",
                                       folder + "-measured"}) +
                           ", and give that folder");
  }
  require(!options.output.empty(), "give --output, the folder for the tables");
  if (!lacks.empty()) throw Error(ErrorKind::usage, lacks);
}

/// \throws Error (usage) for a folder given twice, even by other names
void require_distinct(const Comparison& comparison, const std::vector<MeasuredFolder>& folders) {
  std::vector<std::string> known;
  for (const auto& row : comparison.rows) known.insert(known.end(), row.folders.begin(), row.folders.end());
  for (const auto& folder : folders) {
    for (const auto& other : known)
      if (std::filesystem::equivalent(io::path_of(folder.path), io::path_of(other)))
        throw Error(
            ErrorKind::usage,
            "a folder is given twice" + (folder.path == other ? ": " : ": " + other + " and ") + folder.path);
    known.push_back(folder.path);
  }
}

/// Notes on how the figures were computed.
std::vector<std::string> notes_of(const Comparison& comparison) {
  std::size_t seeds = 0, draws = 0;
  for (const auto& row : comparison.rows)
    for (const auto& cell : row.cells)
      if (cell) seeds = std::max(seeds, cell->seeds), draws = std::max(draws, cell->draws);
  const auto& made_by = comparison.made_by;
  const auto commit = made_by.find("commit");
  const auto value_of = [](const auto& value) { return value.first; };
  const std::string commits = commit == made_by.end() ? "" : listed(commit->second, value_of);
  std::vector<std::string> notes{
      "A row is one camouflage, optimised with up to " + std::to_string(seeds) +
          (seeds == 1 ? " seed" : " seeds") + "; its matched noise has its colours and its spectrum, in " +
          std::to_string(draws) + (draws == 1 ? " draw" : " draws") +
          " for each seed. Counts are over all pictures of all seeds and draws.",
      "Effect: matched noise minus camouflage, in the same views; odds: those of being found with matched "
      "noise over those with the camouflage. Their intervals are over views and, where there are several, "
      "seeds, else draws (two levels); those of P@0.5 and of odds are put together from both shares' in log "
      "odds, of one seed and draw those of P@0.5 by Newcombe's method for paired shares. Odds are - where "
      "they may be below a tenth as well as above ten. Intervals of shares: Wilson's, over the same levels.",
      commits.empty()
          ? std::string("Which commits made it is not known.")
          : "Made by commit" + std::string(commit->second.size() == 1 ? " " : "s ") + commits + "."};
  for (const auto& [fact, values] : made_by) {
    if (fact == "commit" || values.size() == 1) continue;
    notes.push_back("Not all of it was computed by one " +
                    (fact == "instruction_set" ? std::string("instruction set") : fact) +
                    ", on which last bits depend:");
    for (const auto& [value, folder] : values)
      notes.back() += (notes.back().back() == ':' ? " " : ", ") + value + " (" + folder + ")";
    notes.back() += ".";
  }
  if (has_picture_noise(comparison))
    notes.insert(notes.begin() + 1,
                 "Noise drawn in each picture: its paint is replaced by noise with the colours and the "
                 "spectrum that it has there, in the same light.");
  return notes;
}

int run(Options options) {
  std::vector<NamedFolders> rows;
  for (const auto& row : options.rows) rows.push_back(named_folders(row));
  require_complete(options, rows);
  const RunFolder folder(options.output, !is_there(options.output, ErrorKind::write));
  Comparison comparison;
  for (const auto& row : rows) {
    std::vector<MeasuredFolder> folders;
    for (const auto& path : row.folders) folders.push_back(read_measured_folder(path));
    require_distinct(comparison, folders);
    add_row(comparison, row.name, folders);
  }
  for (const auto& note : notes_of(comparison)) options.words.notes.push_back(note);
  for (const auto& sentence : contradictions(comparison)) options.words.notes.push_back(sentence);
  const auto tables = comparison_tables(comparison);
  for (const auto& table : tables) std::cout << text_of(table) << '\n';
  write_comparison(options.output, comparison, tables, options.words);
  std::cout << "table: " << options.output << "/index.html\n";
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line(
      "Puts measurements of several camouflages beside each other: how often each detector finds the car, "
      "what it takes it for, and the effect of each camouflage beyond its matched noise, over all seeds.");
  describe(app, options);
  app.footer("  tabulate --output tables --name loss paper=paper-1,paper-2 vanish=vanish-1,vanish-2");
  return run_program(app, argc, argv, [&] { return run(options); });
}
