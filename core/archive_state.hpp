// States and workspaces in archives.
#pragma once

#include "core/archive.hpp"
#include "core/state.hpp"

namespace gudgeon {

void visit(Archive& archive, AngleMemory& angles);
void visit(Archive& archive, BodyMotion& motion);
void visit(Archive& archive, ContactHistory& history);
void visit(Archive& archive, ContactMemory& memory);
void visit(Archive& archive, ContactSample& sample);
void visit(Archive& archive, Linearisation::ReactionCoupling& coupling);
void visit(Archive& archive, Linearisation::StateCoupling& coupling);
void visit(Archive& archive, State& state);
/// All of it but the number of threads, which is the running program's own.
void visit(Archive& archive, Workspace& ws);

} // namespace gudgeon
