//! Damaged files for the tests of the readers.

pub(super) use reference::damage::survives;
