#pragma once
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

/// A comparison of named numbers, as in `force < 0.1*peak(force) and t > 1` (muParser): what a run may be
/// stopped by.
namespace impact {

class Condition {
public:
  using Value = std::function<double(const std::string& name)>;

  /// Parses `text`; `key` names the option in messages. Names that are no parameter and nothing of the
  /// language of Expression are looked up when it is evaluated. Throws UserError(usage) for what is no
  /// expression.
  Condition(std::string key, std::string text,
            const std::vector<std::pair<std::string, double>>& parameters = {});
  Condition(Condition&&) noexcept;
  Condition& operator=(Condition&&) noexcept;
  ~Condition();

  /// The names that are looked up, each once.
  std::vector<std::string> names() const;

  /// Texts of the arguments of peak(), in order; for each the largest value since it was first noted, not a
  /// number before that.
  const std::vector<std::string>& peak_texts() const;
  std::vector<double>& peaks();

  /// Raises the peaks with the present values; a value that is not a number leaves them as they are.
  void note(const Value& value);
  /// Whether it holds for the present values and peaks. A comparison with what is not a number never holds.
  bool holds(const Value& value) const;

  const std::string& key() const;
  const std::string& text() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace impact
