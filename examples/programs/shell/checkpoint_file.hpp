#pragma once
#include <tapestry/io/npy.hpp>
#include <tapestry/optim/adam.hpp>

namespace tapestry::shell {
inline constexpr std::uint64_t checkpoint_format = 1;

/// Begins a checkpoint of a learning detector with the fields that all have.
/// \param identity  of the run, see identity_text()
inline io::NpzWriter begun_checkpoint(const std::string& identity) {
  io::NpzWriter file;
  file.add("format", checkpoint_format);
  file.add("settings", std::string_view(identity));
  return file;
}

namespace detail {
/// \throws FileError (mismatch) unless two sizes agree
inline void require_size(const std::string& path, const std::string& what, std::size_t expected,
                         std::size_t found) {
  if (expected != found)
    throw file_mismatch(
        {path, "", what + " does not fit the run", std::to_string(expected), std::to_string(found)});
}

inline void add_adam(io::NpzWriter& file, const std::string& name, const optim::AdamState<float>& adam) {
  file.add(name + "_step", adam.step);
  file.add(name + "_first_moment", adam.first_moment);
  file.add(name + "_second_moment", adam.second_moment);
}

inline std::uint64_t number_of(const io::NpzFile& file, const std::string& name) {
  const auto values = file.get(name).as<std::uint64_t>();
  require_size(file.path(), name, 1, values.size());
  return values.front();
}

inline std::vector<float> finite_values(const io::NpzFile& file, const std::string& name, std::size_t count,
                                        float least = std::numeric_limits<float>::lowest()) {
  auto values = file.get(name).as<float>();
  require_size(file.path(), name, count, values.size());
  for (const float value : values)
    if (!(std::isfinite(value) && value >= least))
      throw malformed_file({file.path(), "", name + " holds what no training comes to",
                            least < 0 ? "finite numbers" : "finite numbers of at least 0",
                            std::to_string(value)});
  return values;
}

inline optim::AdamState<float> adam_of(const io::NpzFile& file, const std::string& name, std::size_t count) {
  return {finite_values(file, name + "_first_moment", count),
          finite_values(file, name + "_second_moment", count, 0), number_of(file, name + "_step")};
}
/// The values of a member of the weights' extents; settings of operators among them may be infinite.
inline Array<float, 1> weights_of(const io::NpzFile& file, const std::string& name,
                                  const Array<float, 1>& fresh) {
  const auto values = file.get(name).as<float>();
  require_size(file.path(), name, fresh.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]) && values[i] != fresh(i))
      throw malformed_file({file.path(), "", name + " holds what no training comes to", "finite numbers",
                            std::to_string(values[i])});
  Array<float, 1> weights = fresh;
  std::copy(values.begin(), values.end(), weights.data());
  return weights;
}

/// The histories of a run, [step, term].
template <class Step>
Array<double, 2> rows_of(const std::vector<Step>& history) {
  Array<double, 2> rows(Extents<2>{history.size(), Step::all.size()});
  for (std::size_t i = 0; i < history.size(); ++i)
    for (std::size_t k = 0; k < Step::all.size(); ++k) rows(i, k) = history[i].*Step::all[k].value;
  return rows;
}

template <class Step>
std::vector<Step> history_of(const io::NpzFile& file) {
  const auto rows = file.array<double, 2>("history");
  require_size(file.path(), "history", Step::all.size() * rows.shape(0), rows.size());
  std::vector<Step> history(rows.shape(0));
  for (std::size_t i = 0; i < history.size(); ++i)
    for (std::size_t k = 0; k < Step::all.size(); ++k) history[i].*Step::all[k].value = rows(i, k);
  return history;
}
}  // namespace detail

/// Opens the checkpoint of a run.
/// \throws FileError: malformed (damaged), mismatch (a newer format); Error (in_use) for the checkpoint of a
///         run with other settings
inline io::NpzFile read_checkpoint_file(const std::string& path, const std::string& identity) {
  auto file = io::NpzFile::read(path);
  const auto format = detail::number_of(file, "format");
  if (format != checkpoint_format)
    throw file_mismatch({path, "", "checkpoint of another format", std::to_string(checkpoint_format),
                         std::to_string(format)});
  const auto settings = file.get("settings").as<std::uint8_t>();
  if (std::string(settings.begin(), settings.end()) != identity)
    throw Error(ErrorKind::in_use, path + ": belongs to a run with other settings");
  return file;
}
}  // namespace tapestry::shell
