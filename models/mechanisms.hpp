// Ready mechanisms: models with exact starts, built by name, shared by the command line, the tests,
// the benchmarks and the examples. Names of their bodies and joints: models/README.md.
//
// A new mechanism is one function in a .cpp file of this folder and one line in mechanisms.cpp.
#pragma once

#include "core/model.hpp"

#include <map>
#include <string>
#include <vector>

namespace gudgeon {

/// A number within [minimum, maximum], or, where choices are listed, one of these words.
struct MechanismParameter {
    std::string name;
    std::string default_value;
    std::vector<std::string> choices; // empty: a number
    std::string unit;                 // SI; "" for none
    std::string help;
    bool integer = false;
    double minimum = 0, maximum = 0; // both allowed; of no meaning with choices
    /// Another default where a parameter listed before this one has been given the word.
    std::map<std::string, std::string> default_with;
};

/// The values of all parameters of one mechanism, checked.
class ParameterValues {
  public:
    /// Throws std::out_of_range for a name the mechanism does not have, or that is no number.
    double number(const std::string& name) const { return numbers_.at(name); }
    int integer(const std::string& name) const { return static_cast<int>(numbers_.at(name)); }
    const std::string& word(const std::string& name) const { return words_.at(name); }

    /// Everything as written, defaults included.
    const std::map<std::string, std::string>& words() const { return words_; }
    /// What of it is a number (choices such as 0 and 1 too).
    const std::map<std::string, double>& numbers() const { return numbers_; }

  private:
    friend ParameterValues read_parameters(const struct Mechanism&,
                                           const std::map<std::string, std::string>&);
    std::map<std::string, std::string> words_;
    std::map<std::string, double> numbers_;
};

struct Mechanism {
    std::string name, description;
    std::vector<MechanismParameter> parameters;
    double end = 1, every = 0.01; // s, defaults of a run
    Model (*build)(const ParameterValues&) = nullptr;
};

/// All of them, in the order in which they are listed to the user.
const std::vector<Mechanism>& mechanisms();

/// Null when there is none of this name.
const Mechanism* find_mechanism(const std::string& name);

/// Defaults with the overrides put in. Throws ModelError with the mechanism's name as source and
/// the pointer "/parameters/<name>" for an unknown name or a value that is not allowed.
ParameterValues read_parameters(const Mechanism& mechanism,
                                const std::map<std::string, std::string>& overrides);

/// The model with its name, end, every and numeric parameters filled in; not yet validated.
/// Throws ModelError as read_parameters() does, and for an unknown mechanism (empty pointer).
Model build_mechanism(const std::string& name, const std::map<std::string, std::string>& overrides = {});

/// Progressive spring of the vehicle corner's source (Project Chrono, HMMWV front): tension (N)
/// against elongation (m), odd. hmmwv-corner itself has a linear spring; see models/README.md.
Table hmmwv_progressive_spring();

} // namespace gudgeon
