//! The program, as its users start it.

#![allow(clippy::unwrap_used, reason = "what does not unwrap is a failed test")]

mod backends;
mod bad_input;
mod bake;
mod commands;
mod common;
mod errors;
mod files;
mod film;
mod habits;
#[cfg(unix)]
mod outputs;
mod pictures;
mod plan;
