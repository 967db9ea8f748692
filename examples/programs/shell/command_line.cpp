#include "command_line.hpp"

#include <memory>
#include <tapestry/core/parallel.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>

#include "config_file.hpp"
#include "formatted.hpp"
#include "verbosity.hpp"

namespace tapestry::shell {
namespace {
constexpr const char* exit_status_text =
    "Exit status:\n"
    "  0 done              3 input unreadable or malformed   6 a value is not finite\n"
    "  1 internal fault    4 inputs do not fit each other    7 folder in use\n"
    "  2 wrong usage       5 output cannot be written        8 beyond a limit\n"
    "  128 + n after signal n, with the work so far saved where a run can be resumed";

/// Every option in the form that the user types.
std::vector<std::string> option_words(const CLI::App& app) {
  std::vector<std::string> words;
  for (const auto* option : app.get_options()) {
    for (const auto& name : option->get_lnames()) words.push_back("--" + name);
    for (const auto& name : option->get_snames()) words.push_back("-" + name);
  }
  return words;
}

/// Reports a word that is not an option, with the nearest option.
int unknown_option(const CLI::App& app) {
  const auto extras = app.remaining();
  const std::string unknown = extras.empty() ? std::string() : extras.front();
  const std::string word = unknown.substr(0, unknown.find('='));
  const std::string nearest = io::nearest_word(word, option_words(app));
  std::cerr << "error: unknown " << (word.rfind('-', 0) == 0 ? "option " : "argument ") << for_terminal(word);
  if (!nearest.empty()) std::cerr << "; did you mean " << nearest << "?";
  std::cerr << "\nsee --help\n";
  return static_cast<int>(ErrorKind::usage);
}

/// Empty if all of `text` is one finite number of type T, else a description of the value expected.
template <class T>
std::string complaint_about_number(const std::string& text, const char* expected) {
  T value{};
  bool is_sound = !text.starts_with('+');
  if constexpr (std::same_as<T, double>) {
    is_sound = is_sound && io::parse_number(text, value);
  } else {
    is_sound = is_sound && io::parse_integer(text, value);
  }
  if (is_sound) return {};
  return std::string("expected ") + expected + ", found " + in_quotes(text);
}

/// Refuses values that CLI11 accepts: empty words, the next option in the place of a value, nan and inf, and
/// negative numbers that wrap around.
void require_sound_values(CLI::App& app) {
  const auto missing = [known = option_words(app)](const std::string& text, int values) -> std::string {
    if (text.empty()) return "the value is empty";
    if (std::find(known.begin(), known.end(), text.substr(0, text.find('='))) == known.end()) return {};
    return (values > 1 ? "one of " + std::to_string(values) + " values" : std::string("the value")) +
           " is missing before " + printable(text) +
           (values == 2 ? "; give one number twice for itself" : "");
  };
  const auto complaint = [](const std::string& type, const std::string& text) -> std::string {
    if (type.rfind("UINT", 0) == 0)
      return complaint_about_number<std::uint64_t>(text, "a whole number of at least 0");
    if (type.rfind("INT", 0) == 0) return complaint_about_number<int>(text, "a whole number");
    if (type.rfind("FLOAT", 0) == 0) return complaint_about_number<double>(text, "a finite number");
    return {};
  };
  for (auto* option : app.get_options()) {
    const std::string type = option->get_type_name();
    if (type.empty()) continue;
    option->check([=](const std::string& text) { return complaint(type, text); });
    const int values = option->get_items_expected_min();  // transform() comes before all checks
    option->transform(CLI::Validator([=](std::string& text) { return missing(text, values); }, ""));
  }
}

/// Lines of words, of at most so many columns.
std::string wrapped(const std::string& text, std::size_t columns) {
  std::istringstream words(text);
  std::string lines, word;
  for (std::size_t column = 0; words >> word; column += word.size()) {
    const bool begins = column + 1 + word.size() > columns;
    if (column > 0) lines += begins ? '\n' : ' ';
    column = begins ? 0 : column + (column > 0 ? 1 : 0);
    lines += word;
  }
  return lines;
}

/// The form of --help, at most 80 columns wide. The script for manual pages reads it: names from column 3,
/// texts from column 27.
void form_help(CLI::App& app) {
  constexpr std::size_t text_column = 26, most_columns = 80;
  app.get_formatter()->column_width(text_column);
  app.get_formatter()->label("Positionals", "Arguments");
  app.description(wrapped(app.get_description(), most_columns) + '\n');
  app.footer("Examples:\n" + app.get_footer() + "\n\n" + exit_status_text);
  for (auto* option : app.get_options()) {
    std::string text = option->get_description();
    if (std::getenv("TAPESTRY_MARKED_HELP") == nullptr)  // the braces around words are for completions
      std::erase_if(text, [](char c) { return c == '{' || c == '}'; });
    option->description(wrapped(text, most_columns - text_column));
    if (const auto& value = option->get_default_str(); value == "[]" || value == "\"\"")
      option->default_str("");
  }
}

/// Gives the app a name, the options of every program (--version, --config, --quiet, --verbose), and the form
/// of --help.
void add_general_options(CLI::App& app, const std::string& program) {
  app.name(io::path_of(program).filename().string());
  app.option_defaults()->group("General");
  app.set_version_flag("--version", app.get_name() + " (Tapestry) " TAPESTRY_VERSION_TEXT,
                       "print the version and leave");
  app.set_config("--config", "",
                 "file of options, `name = value` a line (TOML), names without dashes; what the command line "
                 "gives as well wins")
      ->type_name("TEXT");
  add_verbosity_options(app);
  app.set_help_flag("-h,--help", "print this and leave");
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.config_formatter(std::make_shared<ConfigFile>());
}

/// A word in quotes of the shell; if it has control characters, these are written as numbers.
std::string quoted(const std::string& word) {
  if (printable(word) == word) {
    std::string text = "'";
    for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return text + "'";
  }
  std::string text = "$'";
  for (const char c : word) {
    const bool is_plain = c >= ' ' && c <= '~' && c != '\'' && c != '\\';
    text += is_plain ? std::string(1, c)
                     : formatted("\\%03o", static_cast<unsigned>(static_cast<unsigned char>(c)));
  }
  return text + "'";
}
}  // namespace

CommandLine::CommandLine(std::string description) : CLI::App(std::move(description)) {
  option_defaults()->always_capture_default();
}

CommandLine command_line(std::string description) { return CommandLine(std::move(description)); }

void add_threads_option(CLI::App& app, const std::string& help) {
  const auto limit = [](int threads) {
    if (threads < 0 || threads > 1024) throw Error(ErrorKind::usage, "--threads must be 0 to 1024");
    if (threads > 0) limit_threads(threads);
  };
  app.add_option_function<int>("--threads", limit, help)->default_str("0");
}

int parse_arguments(CLI::App& app, int argc, char** argv) {
  platform::open_standard_streams();
  auto words = platform::command_line_words(argc, argv);
  add_general_options(app, words.front());
  form_help(app);
  require_sound_values(app);
  app.get_config_ptr()->check([](const std::string& path) {  // before CLI11 blocks on a FIFO
    (void)io::RegularFile(path, ConfigFile::most_bytes);
    return std::string();
  });
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend() - 1));  // the last word first
    return -1;
  } catch (const CLI::ExtrasError&) {
    return unknown_option(app);
  } catch (const CLI::ConfigError& error) {
    std::cerr << "error: " << for_terminal(app.get_config_ptr()->results().front() + ": " + error.what())
              << "\nsee --help\n";
    return static_cast<int>(ErrorKind::usage);
  } catch (const CLI::FileError&) {  // the file existed a moment ago
    throw malformed_file({app.get_config_ptr()->results().front(), "", "cannot open"});
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    const auto extras = app.remaining();  // a required option may be missing because it was misspelt
    const auto is_option = [](const std::string& word) { return word.size() > 1 && word.front() == '-'; };
    if (std::any_of(extras.begin(), extras.end(), is_option)) return unknown_option(app);
    std::cerr << "error: " << for_terminal(error.what()) << "\nsee --help\n";
    return static_cast<int>(ErrorKind::usage);
  }
}

std::vector<std::string> given_options(const CLI::App& app, const std::vector<std::string>& except) {
  std::vector<std::string> words;
  for (const auto* option : app.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty() || !option->get_configurable()) continue;
    const std::string& name = option->get_lnames().front();
    if (std::find(except.begin(), except.end(), name) != except.end()) continue;
    if (option->get_items_expected_max() == 0 && option->results().front() == "false") continue;  // of a file
    words.push_back("--" + name);
    if (option->get_items_expected_max() == 0) continue;  // a flag
    words.insert(words.end(), option->results().begin(), option->results().end());
  }
  return words;
}

std::string shell_line(const std::vector<std::string>& words) {
  std::string line;
  for (const auto& word : words) {
    const bool plain =
        !word.empty() &&
        word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=,:+@") ==
            std::string::npos;
    line += (line.empty() ? "" : " ") + (plain ? word : quoted(word));
  }
  return line;
}
}  // namespace tapestry::shell
