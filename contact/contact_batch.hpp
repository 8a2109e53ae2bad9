// Turns a contact kernel into a batch. A contact kernel is a force kernel (core/force_batch.hpp) whose
// Element has `law` (NormalLaw), `channel` (number of its first channel, filled here) and that knows
//   contacts                          how many contacts an element has (each law.slots() channels)
//   place(Element, contact)           name and number for the record
//   sample(Evaluation, Element, contact, slot)
// and, where contacts rub (`friction` of the element), for its three states per contact
//   state_terms(Evaluation, Element, contact, source, decay)
//   state_couplings(Evaluation, Element, contact)
#pragma once

#include "contact/contact_law.hpp"
#include "contact/friction_point.hpp"

namespace gudgeon {

struct ContactElement : ForceElement {
    NormalLaw law{Linear{}}; // replaced by the builders
    double share = 1;
    int channel = 0;
    std::optional<FrictionLaw> friction;
    int state = -1; // number of the first friction state, three per contact

    const double* states(const Evaluation& e, int contact) const {
        return state < 0 ? nullptr : e.z + state + 3 * std::ptrdiff_t(contact);
    }
};

struct ContactPlace {
    std::string_view name;
    int number = 0;
    bool rotation = false;
};

/// The three states of a contact of x, from number `state` on.
inline void add_couplings(std::array<Linearisation::StateCoupling, 3> couplings, int state,
                          const ContactElement& x, Linearisation& lin) {
    for (Linearisation::StateCoupling& coupling : couplings) {
        coupling.state = state++;
        coupling.pair = x.pair;
        coupling.a = x.a;
        coupling.b = x.b;
        lin.states.push_back(coupling);
    }
}

template <class Kernel> class ContactBatchOf final : public ForceBatchOf<Kernel> {
  public:
    using Element = typename Kernel::Element;

    bool has_contacts() const override { return true; }

    void declare_contacts(int batch, std::vector<ContactChannel>& channels) override {
        first_ = static_cast<int>(channels.size());
        std::vector<Element>& items = this->elements_.items();
        for (std::size_t i = 0; i < items.size(); ++i) {
            Element& x = items[i];
            x.channel = static_cast<int>(channels.size());
            for (int contact = 0; contact < Kernel::contacts; ++contact)
                for (int slot = 0; slot < x.law.slots(); ++slot) {
                    const ContactPlace place = Kernel::place(x, contact);
                    channels.push_back({batch, x.joint, x.a, x.b, place.name, place.number, place.rotation});
                    owner_.push_back(static_cast<int>(i));
                }
        }
    }

    void sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const override {
        parallel_for(e.threads, 0, std::ssize(owner_), parallel_channels, [&](std::ptrdiff_t k) {
            samples[first_ + k] = sample_contact(e, first_ + static_cast<int>(k));
        });
    }

    void list_elements(std::vector<int>& first_channels) const override {
        for (const Element& x : this->elements())
            first_channels.push_back(x.channel);
    }

    void find_fresh(const Evaluation& e, unsigned char* marks) const override {
        parallel_for(e.threads, 0, this->size(), parallel_channels, [&](std::ptrdiff_t i) {
            const Element& x = this->elements()[i];
            unsigned char found = 0;
            for (int c = x.channel; c < x.channel + channels(x) && !found; ++c)
                found = e.start_speed[c] < 0 && sample_contact(e, c).depth > 0;
            marks[x.channel] = found;
        });
    }

    void sample_element(const Evaluation& e, int first, std::span<ContactSample> samples) const override {
        for (int c = first; c < first + channels(element(first)); ++c)
            samples[c] = sample_contact(e, c);
    }

    ContactSample sample_contact(const Evaluation& e, int channel) const override {
        const Element& x = element(channel);
        const int local = channel - x.channel, slots = x.law.slots();
        ContactSample out = Kernel::sample(e, x, local / slots, local % slots);
        if (x.swapped) {
            out.normal_force = -out.normal_force;
            out.friction_force = -out.friction_force;
        }
        return out;
    }

    void declare_states(std::vector<double>& scales) override {
        for (Element& x : this->elements_.items()) {
            if (!x.friction || !x.friction->has_state())
                continue;
            x.state = static_cast<int>(scales.size());
            scales.insert(scales.end(), 3 * Kernel::contacts, x.friction->state_scale());
        }
    }

    void state_terms(const Evaluation& e, double* source, double* decay) const override {
        if constexpr (rubs)
            for_states([&](const Element& x, int contact, std::ptrdiff_t state) {
                Kernel::state_terms(e, x, contact, source + state, decay + state);
            });
    }

    void add_linearisation(const Evaluation& e, Linearisation& lin) const override {
        ForceBatchOf<Kernel>::add_linearisation(e, lin);
        if constexpr (rubs)
            for_states([&](const Element& x, int contact, std::ptrdiff_t state) {
                add_couplings(Kernel::state_couplings(e, x, contact), static_cast<int>(state), x, lin);
            });
    }

    double depth_of_energy(int channel, double energy) const override {
        const Element& x = element(channel);
        return slot_depth_of_energy(x.law, (channel - x.channel) % x.law.slots(), energy);
    }
    double depth_of_force(int channel, double force) const override {
        const Element& x = element(channel);
        return slot_depth_of_force(x.law, (channel - x.channel) % x.law.slots(), force);
    }

  private:
    static constexpr std::ptrdiff_t parallel_channels = 256;
    static int channels(const Element& x) { return Kernel::contacts * x.law.slots(); }
    static constexpr bool rubs = requires(const Evaluation& e, const Element& x) {
        Kernel::state_couplings(e, x, 0);
    };
    /// f(element, contact, number of the first of its three states)
    template <class F> void for_states(F&& f) const {
        for (const Element& x : this->elements())
            for (int contact = 0; x.state >= 0 && contact < Kernel::contacts; ++contact)
                f(x, contact, x.state + 3 * std::ptrdiff_t(contact));
    }
    const Element& element(int channel) const { return this->elements()[owner_[channel - first_]]; }
    int first_ = 0;
    std::vector<int> owner_; // element of each channel
};

} // namespace gudgeon
