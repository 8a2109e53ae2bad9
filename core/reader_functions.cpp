#include "core/reader_parts.hpp"

namespace gudgeon {

Table read_table(const JsonInput& in) {
    in.expect_keys({"x", "y"});
    Table table{in.at("x").numbers(), in.at("y").numbers()};
    if (table.empty()) // means "no table" in the model
        in.at("x").refuse("a table of 0 points", "at least 2 points");
    return table;
}

TimeFunction read_time_function(const JsonInput& in) {
    if (!in.is_object())
        in.refuse(in.shown() + " is no function of time", "an object {\"kind\": ...}");
    switch (in.at("kind").choice({"constant", "harmonic", "smooth-step", "ramp", "table"})) {
    case 0:
        in.expect_keys({"kind", "value"});
        return ConstantFunction{in.at("value").number()};
    case 1:
        in.expect_keys({"kind", "amplitude", "frequency", "phase", "offset"});
        return HarmonicFunction{in.at("amplitude").number(), in.at("frequency").number(),
                                in.number("phase", 0), in.number("offset", 0)};
    case 2:
        in.expect_keys({"kind", "start", "end", "from", "to"});
        return SmoothStepFunction{in.at("start").number(), in.at("end").number(), in.at("from").number(),
                                  in.at("to").number()};
    case 3:
        in.expect_keys({"kind", "value", "rate", "start"});
        return RampFunction{in.number("value", 0), in.at("rate").number(), in.number("start", 0)};
    default:
        in.expect_keys({"kind", "x", "y"});
        return TableFunction(Table{in.at("x").numbers(), in.at("y").numbers()});
    }
}

} // namespace gudgeon
