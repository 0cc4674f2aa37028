//! Media in the memory of a backend.

use std::fmt::Debug;

use gpu_backend::{Host, Memory};

use crate::scene::Media;

/// A memory that can hold media for a gather.
pub trait MediaMemory: Memory {
    /// Media in this memory.
    type Media<'a>: Debug;
}

/// On the CPU a ray asks the media themselves.
impl MediaMemory for Host {
    type Media<'a> = Media<'a>;
}

/// Media in the memory `M`.
pub type MediaOf<'a, M> = <M as MediaMemory>::Media<'a>;
