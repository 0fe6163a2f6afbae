#include <impact/mesh/state_table.hpp>
#include <stdexcept>
#include <utility>

namespace impact {

StateRow& StateTable::add(StateRow row, std::size_t size, double initial) {
  if (find(row.name)) throw std::logic_error("state row " + row.name + " is added twice");
  if (row.components < 1 || size % static_cast<std::size_t>(row.components) != 0)
    throw std::logic_error("state row " + row.name + ": size is no multiple of its components");
  row.committed.assign(size, initial);
  row.trial.assign(row.has_trial ? size : 0, initial);
  return *rows_.emplace_back(std::make_unique<StateRow>(std::move(row)));
}

const StateRow* StateTable::find(const std::string& name) const {
  for (const auto& row : rows_)
    if (row->name == name) return row.get();
  return nullptr;
}

const StateRow& StateTable::row(const std::string& name) const {
  if (const StateRow* found = find(name)) return *found;
  throw std::out_of_range("no state row named " + name);
}

StateRow& StateTable::row(const std::string& name) {
  return const_cast<StateRow&>(std::as_const(*this).row(name));
}

// Copied where pointers into either half, or what it holds, must stay valid.
void StateTable::commit() {
  for (const auto& row : rows_)
    if (row->rewritten)
      row->committed.swap(row->trial);
    else if (row->has_trial)
      row->committed = row->trial;
}

void StateTable::rollback() {
  for (const auto& row : rows_)
    if (row->has_trial) row->trial = row->committed;
}

} // namespace impact
