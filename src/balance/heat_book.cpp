#include <impact/balance/heat_book.hpp>

namespace impact {

namespace {

std::vector<std::string> heat_contacts(MotionProblem& motion, bool moves) {
  std::vector<std::string> ids;
  for (const ContactInterface& contact : motion.contacts())
    if (contact.passes_heat() && moves) ids.push_back(contact.id());
  return ids;
}

} // namespace

HeatBook::HeatBook(MotionProblem& motion, StateTable& state, bool moves)
    : conditions_(motion.boundary().conditions().size()), contacts_(heat_contacts(motion, moves)),
      row_([&]() -> StateRow& {
        const std::size_t columns = conditions_ + 2 * contacts_.size() + 2;
        return state.add({"ledger_heat", Support::global, static_cast<int>(columns)}, columns);
      }()) {}

void HeatBook::book(const StepRecord& step, double thickness) {
  for (std::size_t c = 0; c < step.heat_supplied.size(); ++c)
    row_.trial[c] += thickness * step.heat_supplied[c];
  for (std::size_t c = 0; c < step.contact_heat.size(); ++c) {
    row_.trial[conditions_ + 2 * c] += thickness * step.contact_heat[c].conducted;
    row_.trial[conditions_ + 2 * c + 1] += thickness * step.contact_heat[c].outside;
  }
  row_.trial[row_.trial.size() - 2] += thickness * step.entropy_supplied;
}

double HeatBook::supplied() const {
  double total = 0;
  for (std::size_t c = 0; c < conditions_; ++c) total += row_.trial[c];
  for (std::size_t c = 0; c < contacts_.size(); ++c) total += row_.trial[conditions_ + 2 * c + 1];
  return total;
}

} // namespace impact
