#include <algorithm>
#include <impact/contact/surface_row.hpp>
#include <impact/math/index.hpp>

namespace impact {

void SurfaceRow::change_surface(std::vector<int> place) {
  place_ = std::move(place);
  const std::size_t n = at(table_->components);
  own_ = std::make_unique<StateRow>(StateRow{table_->name, table_->support, table_->components});
  std::vector<double>& mine = own_->committed;
  mine.assign(n * place_.size(), 0.0);
  for (std::size_t c = 0; c < place_.size(); ++c)
    if (place_[c] >= 0) std::copy_n(&table_->committed[n * at(place_[c])], n, &mine[n * c]);
  own_->trial = mine;
}

void SurfaceRow::tell_table() {
  if (!changed()) return;
  const std::size_t n = at(table_->components);
  for (std::size_t c = 0; c < place_.size(); ++c)
    if (place_[c] >= 0) std::copy_n(&own_->trial[n * c], n, &table_->trial[n * at(place_[c])]);
  own_->committed = own_->trial; // nobody else commits it
}

} // namespace impact
