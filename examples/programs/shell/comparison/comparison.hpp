#pragma once
#include "measured_folder.hpp"

namespace tapestry::shell {
struct ComparedTexture {
  evaluate::DetectionRate rate{};
  double mean_best_confidence = 0;  ///< mean over the seeds
  evaluate::FateCounts fates{};
  std::vector<evaluate::DetectionRate> sweep{};  ///< at swept_thresholds
  double attention = 0;                          ///< share of heat maps on the car, where they were made
  evaluate::PrecisionSummary precision{};
};

/// Results of the noise that is drawn in each picture, and the camouflage's effect beyond it.
struct ComparedPictureNoise {
  ComparedTexture texture{};
  evaluate::PairedDifference p_at_50{};
};

/// Results of one row with one detector, over all seeds.
struct ComparedCell {
  std::size_t seeds = 0, draws = 0, views = 0;
  ComparedTexture camouflage{}, noise{};
  evaluate::AttackSuccess success{};
  evaluate::Effect effect{};
  std::optional<ComparedPictureNoise> picture_noise{};
  std::optional<evaluate::PairedRatio> kept{};  ///< of the effect in the protocol's second part
  Array<double, 2> confidence{};                ///< best, with the camouflage, [seed, view]
  /// Mean best confidence of the first row minus this, if both have equally many seeds.
  std::optional<evaluate::PairedDifference> beyond_first{};
};

/// One line of a comparison: a camouflage, optimised once for each seed.
struct ComparedRow {
  std::string name;
  std::vector<std::string> folders{};                      ///< of the measurements
  std::vector<std::string> runs{};                         ///< of the camouflages, without repeats
  std::vector<std::optional<ComparedCell>> cells{};        ///< by column; none where it was not measured
  std::vector<std::optional<MeasuredContent>> contents{};  ///< by column, of the first seed
};

/// Camouflages beside each other, each measured with the same detectors in the same frames.
struct Comparison {
  std::vector<std::string> columns{};  ///< detectors, and parts of a protocol
  bool maps_attention = false;
  std::vector<std::pair<std::string, std::vector<std::optional<ComparedTexture>>>>
      plain{};  ///< untouched and clean pictures and plain controls, by column
  std::vector<ComparedRow> rows{};
  /// Facts of the programs that made and measured the runs: name, value, and a folder with that value.
  std::map<std::string, std::map<std::string, std::string>> made_by{};
};

inline bool has_picture_noise(const Comparison& comparison) {
  return std::ranges::any_of(comparison.rows, [](const ComparedRow& row) {
    return std::ranges::any_of(row.cells, [](const auto& cell) { return cell && cell->picture_noise; });
  });
}

namespace detail {
struct ColumnMeasurements {
  std::string name;
  std::vector<std::pair<const MeasuredFolder*, MeasuredPart>> seeds;
  std::optional<MeasuredPart> whole{};  ///< part without a condition; the seeds' are compared with it
};

/// The columns of some folders in order of appearance.
inline std::vector<ColumnMeasurements> columns_of(const std::vector<MeasuredFolder>& folders) {
  std::vector<ColumnMeasurements> columns;
  for (const auto& folder : folders) {
    const auto parts = measured_parts(folder.protocol);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const std::string name = folder.protocol.on_photographs ? parts[i].name
                               : parts.size() == 1            ? folder.detector
                                                              : folder.detector + " " + parts[i].name;
      auto column = std::ranges::find(columns, name, &ColumnMeasurements::name);
      if (column == columns.end()) {
        columns.push_back({name, {}});
        column = columns.end() - 1;
        if (folder.protocol.parts.size() == 2 && i == 0) column->whole = parts[1];
      }
      column->seeds.emplace_back(&folder, parts[i]);
    }
  }
  return columns;
}

/// How a texture's pictures follow each other over the seeds of a column, which were measured alike.
inline evaluate::PictureOrder picture_order(const ColumnMeasurements& column, std::size_t texture) {
  const auto& [folder, part] = column.seeds.front();
  return {part.pictures_a_view, folder->outcomes.draws_of(texture), column.seeds.size()};
}

/// Whether the car is found in each picture of a texture, seed by seed.
/// \param times  that each seed's pictures are repeated
inline std::vector<bool> found_in_seeds(const ColumnMeasurements& column, std::size_t texture,
                                        std::size_t times = 1) {
  std::vector<bool> found;
  for (const auto& [folder, part] : column.seeds)
    append(found, evaluate::detail::found_in(folder->outcomes, texture, part.belongs, times));
  return found;
}

inline ComparedTexture compared_texture(const ColumnMeasurements& column, std::size_t texture) {
  ComparedTexture compared;
  std::vector<evaluate::ViewOutcome> fates;
  std::vector<double> confidence, attention, found_confidence;
  std::vector<std::vector<evaluate::BoxOnTarget>> ranked;
  for (const auto& seed : column.seeds) {
    const auto& outcomes = seed.first->outcomes;
    const auto& part = seed.second;  // clang 14 captures no structured binding
    const auto values = [&](const auto& array) {
      return evaluate::measured_values(outcomes, array, texture, part.belongs);
    };
    append(confidence, values(outcomes.best_confidence));
    append(found_confidence, values(outcomes.found_confidence));
    append(attention, values(outcomes.attention));
    append(fates, evaluate::detail::fates_in(outcomes, texture, part.belongs));
    append(ranked, evaluate::ranked_boxes(outcomes, texture, part.belongs));
  }
  const auto order = picture_order(column, texture);
  compared.rate = evaluate::detection_rate(found_in_seeds(column, texture), order);
  compared.fates = evaluate::fate_counts(fates);
  compared.mean_best_confidence = evaluate::detail::mean_of(confidence);
  compared.attention = evaluate::detail::mean_of(attention);
  compared.precision = evaluate::target_precision(ranked);
  compared.sweep = evaluate::rates_above(swept_thresholds, found_confidence, order);
  return compared;
}

/// One row for each seed of a column, [seed, view].
/// \param of_seed  returns a number for each view of a folder's part
template <class OfSeed>
Array<double, 2> seed_rows(const ColumnMeasurements& column, OfSeed of_seed) {
  Array<double, 2> rows{};
  for (std::size_t seed = 0; seed < column.seeds.size(); ++seed) {
    const auto& [folder, part] = column.seeds[seed];
    const std::vector<double> row = of_seed(*folder, part);
    if (seed == 0) rows = zeros<double, 2>({column.seeds.size(), row.size()});
    for (std::size_t view = 0; view < row.size(); ++view) rows(seed, view) = row[view];
  }
  return rows;
}

/// Values of a column: of one seed [draw, view], of several [seed, view], each the mean over its draws.
/// \param of_seed  returns [draw, view] of a folder's part
template <class OfSeed>
Array<double, 2> rows_of_draws_or_seeds(const ColumnMeasurements& column, OfSeed of_seed) {
  if (column.seeds.size() == 1) return of_seed(*column.seeds.front().first, column.seeds.front().second);
  return seed_rows(column, [&](const MeasuredFolder& folder, const MeasuredPart& part) {
    return evaluate::detail::means_over_draws(of_seed(folder, part));
  });
}

/// Differences of best confidence between matched noise and the camouflage.
inline Array<double, 2> compared_differences(const ColumnMeasurements& column) {
  return rows_of_draws_or_seeds(column, [&](const MeasuredFolder& folder, const MeasuredPart& part) {
    return evaluate::draw_differences(folder.outcomes, folder.outcomes.best_confidence, 2, 1, part.belongs,
                                      part.pictures_a_view);
  });
}

/// Shares found of each view with a control and with the camouflage, of one seed [draw, view], of several
/// [seed, view].
/// \param control  number of its texture; matched noise is 2
inline std::pair<Array<double, 2>, Array<double, 2>> compared_found(const ColumnMeasurements& column,
                                                                    std::size_t control) {
  const auto found = [&](std::size_t texture) {
    return rows_of_draws_or_seeds(column, [&](const MeasuredFolder& folder, const MeasuredPart& part) {
      return evaluate::draw_means(folder.outcomes, folder.outcomes.found, texture, part.belongs,
                                  part.pictures_a_view);
    });
  };
  auto of_control = found(control), camouflage = found(1);
  if (column.seeds.size() == 1) camouflage = evaluate::mean_for_draws(camouflage, of_control.shape(0));
  return {std::move(of_control), std::move(camouflage)};
}

/// The effect in the column's part divided by that in the whole, see evaluate::share_kept().
/// \param differences  of the part, see compared_differences()
inline std::optional<evaluate::PairedRatio> compared_kept(const ColumnMeasurements& column,
                                                          const Array<double, 2>& differences) {
  if (!column.whole) return std::nullopt;
  ColumnMeasurements whole = column;
  for (auto& [folder, part] : whole.seeds) part = *column.whole;
  return evaluate::share_kept(differences, compared_differences(whole));
}

/// The number of the noise that is drawn in each picture; none where a seed was measured without it.
inline std::optional<std::size_t> picture_noise_of(const ColumnMeasurements& column) {
  std::optional<std::size_t> number;
  for (const auto& [folder, part] : column.seeds) {
    const auto texture = std::ranges::find(folder->textures, std::string(evaluate::picture_noise_name));
    if (texture == folder->textures.end()) return std::nullopt;
    number = static_cast<std::size_t>(texture - folder->textures.begin());
  }
  return number;
}

/// P@0.5 with a control minus that with the camouflage.
/// \param found  of both, see compared_found()
inline evaluate::PairedDifference compared_rates(const ColumnMeasurements& column, std::size_t control,
                                                 const std::pair<Array<double, 2>, Array<double, 2>>& found) {
  const std::size_t draws = column.seeds.front().first->outcomes.draws_of(control);
  const auto of_views =
      evaluate::rate_difference(found_in_seeds(column, control), found_in_seeds(column, 1, draws),
                                picture_order(column, control).pictures_a_view());
  return evaluate::two_level_rate_difference(found.first, found.second, of_views);
}

inline ComparedCell compared_cell(const ColumnMeasurements& column) {
  ComparedCell cell;
  cell.seeds = column.seeds.size();
  cell.camouflage = compared_texture(column, 1);
  cell.noise = compared_texture(column, 2);
  cell.draws = column.seeds.front().first->outcomes.draws_of(2);
  cell.success = evaluate::attack_success_rate(found_in_seeds(column, 0), found_in_seeds(column, 1),
                                               picture_order(column, 1));
  const auto differences = compared_differences(column);
  cell.views = differences.shape(1);
  const auto found = compared_found(column, 2);
  cell.effect = {evaluate::matched_noise_name, evaluate::two_level_difference(differences, {}, 1),
                 compared_rates(column, 2, found)};
  cell.effect.odds_ratio = evaluate::odds_ratio(
      found.first, found.second, picture_order(column, 2).pictures_a_view() / found.first.shape(0),
      column.seeds.front().second.pictures_a_view);
  if (const auto number = picture_noise_of(column))
    cell.picture_noise = ComparedPictureNoise{
        compared_texture(column, *number), compared_rates(column, *number, compared_found(column, *number))};
  cell.kept = compared_kept(column, differences);
  cell.confidence = seed_rows(column, [](const MeasuredFolder& folder, const MeasuredPart& part) {
    return evaluate::view_means(folder.outcomes, folder.outcomes.best_confidence, 1, part.belongs,
                                part.pictures_a_view);
  });
  return cell;
}

inline const MeasuredContent& content_of(const MeasuredFolder& folder, const std::string& column) {
  if (!folder.protocol.on_photographs) return folder.contents.front();
  const auto& columns = folder.protocol.table.columns;
  return folder.contents.at(static_cast<std::size_t>(std::ranges::find(columns, column) - columns.begin()));
}

/// \throws Error (mismatch) unless the folders of a column are different seeds of one camouflage, measured
/// alike
inline void require_alike(const std::string& row, const ColumnMeasurements& column) {
  const auto& first = *column.seeds.front().first;
  for (std::size_t i = 1; i < column.seeds.size(); ++i) {
    const MeasuredFolder& folder = *column.seeds[i].first;
    for (std::size_t k = 0; k < i; ++k)
      require_seeds(row, content_of(*column.seeds[k].first, column.name), content_of(folder, column.name));
    if (folder.outcomes.state.storage() != first.outcomes.state.storage() ||
        folder.outcomes.draws_of(2) != first.outcomes.draws_of(2))
      throw Error(ErrorKind::mismatch, row + ": " + folder.path + " and " + first.path +
                                           " were not measured in the same frames with the same draws");
  }
}

/// \returns  nothing where a row was not measured in this column, or in another number of seeds
inline std::optional<evaluate::PairedDifference> difference_to(const ComparedRow& first,
                                                               const ComparedCell& cell, std::size_t column) {
  if (column >= first.cells.size() || !first.cells[column] || first.cells[column]->seeds != cell.seeds)
    return std::nullopt;
  auto differences = first.cells[column]->confidence;
  for (std::size_t i = 0; i < differences.size(); ++i) differences.data()[i] -= cell.confidence.data()[i];
  return evaluate::two_level_difference(differences, {}, 1);
}

/// \throws Error (mismatch) unless a row was measured as the others: in the same frames, and in each column
/// by the same detector, class and thresholds
inline void require_same_views(const Comparison& comparison, const ComparedRow& row, const ComparedCell& cell,
                               std::size_t column) {
  for (const auto& other : comparison.rows) {
    const std::string rows = other.name + " and " + row.name;
    for (const auto& content : other.contents)
      if (content) require_same(rows, *content, *row.contents[column], &MeasuredContent::frames);
    if (column < other.contents.size() && other.contents[column])
      require_comparable(rows, *other.contents[column], *row.contents[column]);
    if (column < other.cells.size() && other.cells[column] && other.cells[column]->views != cell.views)
      throw Error(ErrorKind::mismatch, row.name + ": measured in " + std::to_string(cell.views) + " views, " +
                                           other.name + " in " + std::to_string(other.cells[column]->views));
  }
}

/// The textures of a folder that do not depend on its camouflage: untouched, clean, random and solid colours.
inline std::vector<std::string> plain_textures(const MeasuredFolder& folder) {
  std::vector<std::string> names;
  if (!folder.protocol.bare_name.empty()) names.push_back(folder.protocol.bare_name);
  names.push_back(folder.textures.front());
  for (const auto& control : evaluate::plain_controls(1, 1))
    if (std::ranges::count(folder.textures, control.name) > 0) names.push_back(control.name);
  return names;
}

/// Adds the first seed's results for pictures without a camouflage to a column that has none yet.
inline void add_plain(Comparison& comparison, const ColumnMeasurements& column, std::size_t index) {
  const MeasuredFolder& folder = *column.seeds.front().first;
  for (const std::string& name : plain_textures(folder)) {
    auto place = std::ranges::find_if(comparison.plain, [&](const auto& row) { return row.first == name; });
    if (place == comparison.plain.end()) place = comparison.plain.insert(comparison.plain.end(), {name, {}});
    auto& cells = place->second;
    cells.resize(comparison.columns.size());
    const auto texture = std::ranges::find(folder.textures, name) - folder.textures.begin();
    if (!cells[index])
      cells[index] =
          compared_texture({column.name, {column.seeds.front()}}, static_cast<std::size_t>(texture));
  }
}
}  // namespace detail

/// Adds a row: the measured folders of its seeds, by one or several detectors.
/// \throws Error (mismatch) if a folder has no camouflage, or the folders do not fit each other or the rows
inline void add_row(Comparison& comparison, const std::string& name,
                    const std::vector<MeasuredFolder>& folders) {
  ComparedRow row{name};
  for (const auto& folder : folders) {
    if (!folder.has_camouflage())
      throw Error(ErrorKind::mismatch, folder.path + ": a measurement without a camouflage");
    row.folders.push_back(folder.path);
    for (const auto& [fact, value] : folder.made_by) comparison.made_by[fact].try_emplace(value, folder.path);
    if (!folder.run.empty() && std::ranges::count(row.runs, folder.run) == 0) row.runs.push_back(folder.run);
    comparison.maps_attention = comparison.maps_attention || folder.protocol.maps_attention;
  }
  for (const auto& column : detail::columns_of(folders)) {
    detail::require_alike(name, column);
    auto place = std::ranges::find(comparison.columns, column.name);
    if (place == comparison.columns.end())
      place = comparison.columns.insert(comparison.columns.end(), column.name);
    const auto index = static_cast<std::size_t>(place - comparison.columns.begin());
    row.cells.resize(comparison.columns.size());
    row.contents.resize(comparison.columns.size());
    row.contents[index] = detail::content_of(*column.seeds.front().first, column.name);
    row.cells[index] = detail::compared_cell(column);
    detail::require_same_views(comparison, row, *row.cells[index], index);
    if (!comparison.rows.empty())
      row.cells[index]->beyond_first =
          detail::difference_to(comparison.rows.front(), *row.cells[index], index);
    detail::add_plain(comparison, column, index);
  }
  comparison.rows.push_back(std::move(row));
}
}  // namespace tapestry::shell
