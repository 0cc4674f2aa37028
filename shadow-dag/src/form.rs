//! The two ways to store nodes.

/// How nodes are stored. Answers are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Form {
    /// References of 32 bits: the quickest to walk.
    Plain,
    /// References and shapes of as many bits as each level needs, nothing
    /// stored twice within a node: 0.25 to 0.33 of the size of plain nodes for
    /// closed scenes, 0.38 to 0.49 for open ones.
    Packed,
}
