// Turns a contact kernel into a batch. A contact kernel is a force kernel (core/force_batch.hpp) whose
// Element has `law` (NormalLaw), `channel` (number of its first channel, filled here) and that knows
//   contacts                          how many contacts an element has (each law.slots() channels)
//   place(Element, contact)           name and number for the record
//   sample(Evaluation, Element, contact, slot)
#pragma once

#include "contact/contact_law.hpp"

namespace gudgeon {

struct ContactElement : ForceElement {
    NormalLaw law{Linear{}}; // replaced by the builders
    double share = 1;
    int channel = 0;
};

struct ContactPlace {
    std::string_view name;
    int number = 0;
};

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
                    channels.push_back({batch, x.joint, x.a, x.b, place.name, place.number});
                    owner_.push_back(static_cast<int>(i));
                }
        }
    }

    void sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const override {
        for (std::size_t k = 0; k < owner_.size(); ++k)
            samples[first_ + k] = sample_contact(e, first_ + static_cast<int>(k));
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

    double depth_of_energy(int channel, double energy) const override {
        const Element& x = element(channel);
        return slot_depth_of_energy(x.law, (channel - x.channel) % x.law.slots(), energy);
    }
    double depth_of_force(int channel, double force) const override {
        const Element& x = element(channel);
        return slot_depth_of_force(x.law, (channel - x.channel) % x.law.slots(), force);
    }

  private:
    const Element& element(int channel) const { return this->elements()[owner_[channel - first_]]; }
    int first_ = 0;
    std::vector<int> owner_; // element of each channel
};

} // namespace gudgeon
