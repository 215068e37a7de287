//! Reflection of a composed module through naga: what each entry point reads and writes.
