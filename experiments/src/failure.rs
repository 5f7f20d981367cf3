//! Why there is no result.

/// Any error, which may come from another thread.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;
