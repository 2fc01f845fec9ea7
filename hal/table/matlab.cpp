#include "hal/table/matlab.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fstream>
#include <map>
#include <matio.h>
#include <set>

#include "hal/table/cell_text.hpp"
#include "hal/table/sheet_cells.hpp"
#include "model/files/error.hpp"

namespace smaservo::hal {
namespace {

using Variable = std::shared_ptr<matvar_t>;
using File = std::unique_ptr<mat_t, int (*)(mat_t*)>;

constexpr std::string_view class_names[] = {
    "object", "cell",  "struct", "object", "char",   "sparse", "double", "single",   "int8",
    "uint8",  "int16", "uint16", "int32",  "uint32", "int64",  "uint64", "function", "object"};

std::string_view class_of(const matvar_t& variable) {
  const auto index = static_cast<std::size_t>(variable.class_type);
  return variable.isLogical != 0          ? "logical"
         : index < std::size(class_names) ? class_names[index]
                                          : "object";
}

/// A class that the library does not know, as MATLAB's own, is empty in a file of 7.3: an empty
/// array has the class of its numbers.
bool is_object(const matvar_t& variable) {
  return variable.class_type == MAT_C_EMPTY || variable.class_type == MAT_C_OBJECT ||
         variable.class_type == MAT_C_OPAQUE || variable.class_type == MAT_C_FUNCTION;
}

bool is_numeric(const matvar_t& variable) {
  return MAT_C_DOUBLE <= variable.class_type && variable.class_type <= MAT_C_UINT64 &&
         variable.isComplex == 0 && variable.rank == 2 && variable.dims != nullptr;
}

std::size_t rows_of(const matvar_t& variable) {
  return variable.dims[0];
}
std::size_t columns_of(const matvar_t& variable) {
  return variable.dims[1];
}

std::size_t longer_side(const matvar_t& variable) {
  return std::max(rows_of(variable), columns_of(variable));
}
std::size_t shorter_side(const matvar_t& variable) {
  return std::min(rows_of(variable), columns_of(variable));
}

/// The variable's numbers as text; null where the library has not read as many as its size says.
template <class T>
std::function<std::string(std::size_t)> numbers_as(const matvar_t& variable) {
  const std::size_t there = variable.nbytes / sizeof(T);
  // A damaged file may say any size.
  if (variable.data == nullptr || variable.data_size != static_cast<int>(sizeof(T)) ||
      rows_of(variable) > there / std::max<std::size_t>(columns_of(variable), 1)) {
    return nullptr;
  }
  const auto* const data = static_cast<const T*>(variable.data);
  return [data](std::size_t i) {
    if constexpr (std::is_floating_point_v<T>) {
      return number_text(static_cast<double>(data[i]));
    } else {
      return fmt::format("{}", +data[i]);
    }
  };
}

std::function<std::string(std::size_t)> numbers_of(const matvar_t& variable) {
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      return numbers_as<double>(variable);
    case MAT_C_SINGLE:
      return numbers_as<float>(variable);
    case MAT_C_INT8:
      return numbers_as<std::int8_t>(variable);
    case MAT_C_UINT8:
      return numbers_as<std::uint8_t>(variable);
    case MAT_C_INT16:
      return numbers_as<std::int16_t>(variable);
    case MAT_C_UINT16:
      return numbers_as<std::uint16_t>(variable);
    case MAT_C_INT32:
      return numbers_as<std::int32_t>(variable);
    case MAT_C_UINT32:
      return numbers_as<std::uint32_t>(variable);
    case MAT_C_INT64:
      return numbers_as<std::int64_t>(variable);
    case MAT_C_UINT64:
      return numbers_as<std::uint64_t>(variable);
    default:
      return nullptr;
  }
}

/// A row of characters; empty where it is none. Of characters in 16 bits, those that are not ASCII
/// become '?': names of quantities and units hardly have any.
std::string text_of(const matvar_t& variable) {
  std::string text;
  if (variable.class_type != MAT_C_CHAR || variable.rank != 2 || rows_of(variable) != 1 ||
      variable.data == nullptr || variable.data_size < 1) {
    return text;
  }
  const auto* const bytes = static_cast<const unsigned char*>(variable.data);
  const auto step = static_cast<std::size_t>(variable.data_size);
  for (std::size_t i = 0; i + step <= variable.nbytes && i < columns_of(variable) * step;
       i += step) {
    std::uint16_t unit = bytes[i];
    if (step == 2) {
      std::memcpy(&unit, bytes + i, 2);
    }
    const bool plain = unit < 0x80 || step == 1;
    text += plain ? static_cast<char>(unit) : '?';
  }
  return text;
}

/// The texts of a cell array; empty where it holds anything else.
std::vector<std::string> texts_of(matvar_t& cells) {
  std::vector<std::string> texts;
  if (cells.class_type != MAT_C_CELL || cells.rank != 2 || cells.data == nullptr ||
      rows_of(cells) >
          cells.nbytes / sizeof(matvar_t*) / std::max<std::size_t>(columns_of(cells), 1)) {
    return texts;
  }
  for (std::size_t i = 0; i < rows_of(cells) * columns_of(cells); ++i) {
    const matvar_t* const cell = Mat_VarGetCell(&cells, static_cast<int>(i));
    texts.push_back(cell == nullptr ? "" : text_of(*cell));
    if (texts.back().empty()) {
      return {};
    }
  }
  return texts;
}

/// Whether the parts of a MATLAB 5 file end where the file ends. The library takes a part that was
/// cut off for the end.
void check_end(const char* path) {
  std::ifstream in(path, std::ios::binary);
  std::array<char, 128> head{};
  in.read(head.data(), head.size());
  const std::string_view order(&head[126], 2);
  if (!in || (order != "IM" && order != "MI")) {
    throw files::UserError("the file is damaged or was cut off in its first 128 bytes");
  }
  const bool swapped = (order == "IM") != (std::endian::native == std::endian::little);
  const auto number = [&](const char* at) {
    std::array<char, 4> bytes{at[0], at[1], at[2], at[3]};
    if (swapped) {
      std::ranges::reverse(bytes);
    }
    return std::bit_cast<std::uint32_t>(bytes);
  };
  in.seekg(0, std::ios::end);
  const auto size = static_cast<std::uint64_t>(in.tellg());
  constexpr std::uint32_t matrix = 14, compressed = 15;
  for (std::uint64_t at = head.size(); at < size;) {
    std::array<char, 8> tag{};
    in.seekg(static_cast<std::streamoff>(at));
    in.read(tag.data(), tag.size());
    at += tag.size() + number(&tag[4]);
    if (!in || at > size) {
      throw files::UserError("the file was cut off, or is damaged");
    }
    if (const std::uint32_t type = number(tag.data()); type != matrix && type != compressed) {
      throw files::UserError("the file is damaged: a part of it is no variable");
    }
  }
}

/// A variable or a field that may become columns.
struct Candidate {
  std::string name;
  matvar_t* variable;
};

class Reading {
 public:
  explicit Reading(const char* path)
      : path_(path),
        size_(std::filesystem::file_size(path)),
        file_(Mat_Open(path, MAT_ACC_RDONLY), Mat_Close) {
    if (!file_) {
      throw files::UserError("the file is damaged or was cut off, or no file of MATLAB 5 to 7.3");
    }
  }

  MatlabTable table() {
    MatlabTable made;
    const mat_ft version = Mat_GetVersion(file_.get());
    made.format = version == MAT_FT_MAT73 ? "MATLAB 7.3 file" : "MATLAB 5 file";
    if (version == MAT_FT_MAT5) {
      check_end(path_);
    }
    list();
    find_rows();
    if (rows_ > 1) {
      fill(made);
    }
    if (made.columns.empty()) {
      refuse();
    }
    made.rows = rows_;
    made.kept.assign(variables_.begin(), variables_.end());
    return made;
  }

 private:
  /// Reads all variables that may be columns or the names of columns.
  void list() {
    std::vector<std::string> names;
    while (const Variable found{Mat_VarReadNextInfo(file_.get()), Mat_VarFree}) {
      // The library does not know the names of objects in files of MATLAB 5. These keep their
      // content in a variable without a name.
      const bool has_name = found->name != nullptr && *found->name != '\0';
      if (!has_name && !is_object(*found)) {
        continue;
      }
      const std::string name = has_name ? found->name : "";
      describe(*found, name);
      check_size(*found, name);
      if (is_object(*found)) {
        objects_.push_back(name);
      } else if (is_numeric(*found) || found->class_type == MAT_C_STRUCT ||
                 found->class_type == MAT_C_CELL) {
        names.push_back(name);
      }
    }
    for (const std::string& name : names) {
      const Variable read{Mat_VarRead(file_.get(), name.c_str()), Mat_VarFree};
      if (!read) {
        throw files::UserError(fmt::format("the file is damaged: '{}' cannot be read", name));
      }
      variables_.push_back(read);
      if (read->class_type == MAT_C_STRUCT) {
        add_fields(name, *read);
      } else {
        candidates_.push_back({name, read.get()});
      }
    }
  }

  void add_fields(const std::string& name, matvar_t& variable) {
    if (variable.rank != 2 || longer_side(variable) != 1 || shorter_side(variable) != 1) {
      return;
    }
    char* const* const fields = Mat_VarGetStructFieldnames(&variable);
    for (std::size_t i = 0; i < Mat_VarGetNumberOfFields(&variable); ++i) {
      matvar_t* const field = Mat_VarGetStructFieldByIndex(&variable, i, 0);
      if (fields != nullptr && fields[i] != nullptr && field != nullptr) {
        describe(*field, name + '.' + fields[i]);
        candidates_.push_back({fields[i], field});
        owners_[field] = name;
      }
    }
  }

  /// A size that so small a file cannot hold, even compressed a thousandfold, is damage: the
  /// library would take memory for it.
  void check_size(const matvar_t& variable, const std::string& name) const {
    std::uintmax_t left = 1100 * size_;
    for (int i = 0; variable.dims != nullptr && i < variable.rank; ++i) {
      left /= std::max<std::size_t>(variable.dims[i], 1);
    }
    if (left == 0) {
      throw files::UserError(fmt::format(
          "the file is damaged: the size of '{}' is more than the file can hold", name));
    }
  }

  void describe(const matvar_t& variable, const std::string& name) {
    std::string size;
    for (int i = 0; variable.dims != nullptr && i < variable.rank; ++i) {
      size += fmt::format("{}{}", i == 0 ? "" : " x ", variable.dims[i]);
    }
    listed_.push_back(fmt::format("{} ({}{} {})", name, variable.isComplex != 0 ? "complex " : "",
                                  class_of(variable), is_object(variable) ? "of MATLAB" : size));
  }

  /// The length that most columns have; of several the longest.
  void find_rows() {
    std::map<std::size_t, std::size_t> columns;
    for (const Candidate& candidate : candidates_) {
      if (is_numeric(*candidate.variable) && shorter_side(*candidate.variable) > 0) {
        columns[longer_side(*candidate.variable)] += shorter_side(*candidate.variable);
      }
    }
    columns.erase(1);
    const auto most = std::ranges::max_element(
        columns, {}, [](const auto& length) { return std::pair(length.second, length.first); });
    rows_ = most == columns.end() ? 0 : most->first;
  }

  bool is_column_or_matrix(const matvar_t& variable) const {
    return is_numeric(variable) && (rows_of(variable) == rows_ || columns_of(variable) == rows_);
  }

  void fill(MatlabTable& made) {
    std::vector<std::vector<std::string>> texts;
    std::size_t vectors = 0;
    std::size_t matrices = 0;
    for (const Candidate& candidate : candidates_) {
      matvar_t& variable = *candidate.variable;
      if (is_column_or_matrix(variable)) {
        ++(shorter_side(variable) == 1 ? vectors : matrices);
      } else if (is_numeric(variable) && longer_side(variable) == 1 &&
                 shorter_side(variable) == 1) {
        if (const auto number = numbers_of(variable)) {
          made.scalars.push_back(fmt::format("{} = {}", csv_field(candidate.name), number(0)));
        }
      } else if (std::vector<std::string> all = texts_of(variable); !all.empty()) {
        texts.push_back(std::move(all));
      }
    }
    if (matrices != 1) {
      texts.clear();
    }
    for (const Candidate& candidate : candidates_) {
      if (is_column_or_matrix(*candidate.variable)) {
        add_columns(made, candidate, texts);
      }
    }
    made.left_out = objects_.size();
    made.has_names = vectors > 0 || matrices != 1 || named_;
  }

  void add_columns(MatlabTable& made, const Candidate& candidate,
                   const std::vector<std::vector<std::string>>& texts) {
    const matvar_t& variable = *candidate.variable;
    const bool down = rows_of(variable) == rows_;
    const auto numbers = numbers_of(variable);
    if (!numbers) {
      throw files::UserError(
          fmt::format("the file is damaged: '{}' cannot be read", candidate.name));
    }
    const std::size_t count = down ? columns_of(variable) : rows_of(variable);
    constexpr std::size_t most = 10'000;
    if (count > most || made.columns.size() + count > most) {
      throw files::UserError(fmt::format("has more than {} columns ('{}'); save fewer variables",
                                         most, candidate.name));
    }
    const auto fits = std::ranges::find(texts, count, &std::vector<std::string>::size);
    const bool has_texts = count > 1 && fits != texts.end();
    named_ = named_ || has_texts;
    for (std::size_t k = 0; k < count; ++k) {
      std::string name = has_texts    ? (*fits)[k]
                         : count == 1 ? candidate.name
                                      : fmt::format("{}_{}", candidate.name, k + 1);
      // Of fields with the same name the later ones get that of their struct.
      if (const auto owner = owners_.find(candidate.variable);
          !taken_.insert(name).second && owner != owners_.end()) {
        name = owner->second + '.' + name;
      }
      const std::size_t first = down ? k * rows_ : k;
      const std::size_t step = down ? 1 : count;
      made.columns.push_back({std::move(name), [numbers, first, step](std::size_t row) {
                                return numbers(first + step * row);
                              }});
    }
  }

  [[noreturn]] void refuse() const {
    if (!objects_.empty()) {
      const std::string& name = objects_.front();
      throw files::UserError(fmt::format(
          "holds {}an object of MATLAB, as a table, timetable or timeseries is, which only MATLAB "
          "reads; there, writetable({}, \"run.csv\") makes a CSV file of a table, "
          "writetimetable() of a timetable",
          name.empty() ? "" : fmt::format("'{}', ", name), name.empty() ? "T" : name));
    }
    if (listed_.empty()) {
      throw files::UserError("has no variable that can be read; it was cut off, or is damaged");
    }
    constexpr std::size_t shown = 10;
    const std::vector<std::string> some(
        listed_.begin(),
        listed_.begin() + static_cast<std::ptrdiff_t>(std::min(shown, listed_.size())));
    throw files::UserError(fmt::format(
        "has no columns of numbers; wanted are vectors of one length, by themselves or in a "
        "struct, or a matrix, of real numbers; there are: {}{}",
        fmt::join(some, ", "),
        some.size() < listed_.size() ? fmt::format(" and {} more", listed_.size() - some.size())
                                     : ""));
  }

  const char* path_;
  std::uintmax_t size_;
  File file_;
  std::vector<Variable> variables_;
  std::vector<Candidate> candidates_;
  std::map<const matvar_t*, std::string> owners_;  ///< the struct of a field
  std::vector<std::string> listed_, objects_;
  std::set<std::string> taken_;
  std::size_t rows_ = 0;
  bool named_ = false;  ///< columns of a matrix, by a cell array
};

}  // namespace

MatlabTable read_matlab(const char* path) {
  return Reading(path).table();
}

}  // namespace smaservo::hal
