//! What judges the crates of this workspace.
pub mod generators;
pub mod hard_cases;
pub mod metrics;
pub mod oracle;
pub mod scenes;
pub mod shapes;
pub mod suite;
pub mod tolerances;
