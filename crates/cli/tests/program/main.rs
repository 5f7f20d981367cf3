//! The program from outside, as a user has it: files in, files out, what it says, and how it ends.

#![allow(clippy::unwrap_used)]

mod bad_input;
mod browser;
mod commands;
mod common;
mod evaluation;
mod formats;
mod interrupts;
mod open3d;
mod real_scans;
mod register;
