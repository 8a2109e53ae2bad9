// Parts of the model writer that describe imperfect joints.
#pragma once

#include "core/model.hpp"

#include <nlohmann/json.hpp>

namespace gudgeon {

nlohmann::ordered_json to_json(const Table& table);
nlohmann::ordered_json to_json(const Friction& friction);
/// The beam as the user described it; of an expanded one the starts of its pieces come from the bodies.
nlohmann::ordered_json to_json(const Beam& beam, const Model& model);
/// "fidelity": one word, or a word per relative motion.
void put_fidelity(nlohmann::ordered_json& out, const Joint& joint);
/// "clearance", "bearing", "stops" and "friction" of a joint.
void put_contacts(nlohmann::ordered_json& out, const Joint& joint);

} // namespace gudgeon
