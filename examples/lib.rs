//! The code of the project's README is a doctest of this package.

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
