//! What judges the crates of this workspace.
pub mod metrics;
pub mod oracle;
