#include "runtime/cook/cook_events.hpp"

#include <algorithm>
#include <cmath>

namespace runtime {

namespace {

Progress progress(const CookState& cook, std::size_t done)
{
    Progress p{done, cook.wants.size(), seconds_since(cook.start), 0};
    const double finished = static_cast<double>(done);
    const double remaining = static_cast<double>(cook.wants.size() - done);
    const double at_once = std::clamp(cook.busy_seconds / std::max(p.elapsed, 1e-9), 1.0,
                                      static_cast<double>(cook.threads));
    p.left = done == 0 ? std::nan("") : cook.repeating_seconds / finished * remaining / at_once;
    return p;
}

void tell(CookState& cook, const ArrivedEvent& e)
{
    if (cook.arrived) cook.arrived(cook.wants[e.want], e.result->values);
    if (cook.observer) cook.observer->progressed(progress(cook, e.done));
}
void tell(CookState& cook, const WroteEvent& e)
{
    if (cook.observer) cook.observer->wrote(e.node, e.frame, e.file);
}
void tell(CookState& cook, const ToldEvent& e)
{
    if (cook.observer) cook.observer->told(*e);
}
void tell(CookState& cook, const Warning& w)
{
    if (cook.observer) cook.observer->warned(w);
}
void tell(CookState& cook, const Failure& f)
{
    if (cook.observer) cook.observer->failed(f);
}
void tell(CookState& cook, const Run& r)
{
    // Work that comes back each frame foretells what is left; what ran once does not.
    if (cook.keys.varies(r.node) && r.preparation < 0) cook.repeating_seconds += r.seconds;
    cook.busy_seconds += r.seconds;
    if (cook.observer) cook.observer->ran(r);
}

}  // namespace

void report_events(CookState& cook)
{
    const std::lock_guard one(cook.reporting);
    std::vector<CookEvent> events;
    {
        const std::lock_guard lock(cook.mutex);
        events.swap(cook.events);
    }
    for (const CookEvent& event : events) {
        std::visit([&cook](const auto& e) { tell(cook, e); }, event);
    }
}

}  // namespace runtime
