//! Media in the memory of a backend.

use std::fmt::Debug;

use gpu_backend::{Host, Memory};

use crate::scene::Media;

/// A memory in which media are ready for a gather.
pub trait MediaMemory: Memory {
    /// The media there.
    type Media<'a>: Debug;
}

/// What a ray asks on the CPU.
impl MediaMemory for Host {
    type Media<'a> = Media<'a>;
}

/// Media in the memory `M`.
pub type MediaOf<'a, M> = <M as MediaMemory>::Media<'a>;
