// A header of the program that uses Gudgeon: Gudgeon's own headers must not take it for theirs.
#error "the program's core/types.hpp was included instead of <gudgeon/core/types.hpp>"
