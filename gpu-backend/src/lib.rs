//! Where data lives and where steps run.
//!
//! The package is `crepuscular-backend` and the library `gpu_backend`: `Cargo.toml` has the first
//! name, and `use` the second. The algorithm crates re-export it as `gpu_backend`.
//!
//! Every crate of this workspace computes in *steps*: rasterise a shadow map,
//! gather the light along a bundle of rays, scan a grid. A step takes and
//! returns buffers that stay where the work is done. This crate defines
//! those buffers and the trait that all backends share, and knows nothing of
//! scenes or light.
//!
//! * [`Memory`] is a family of buffer types: [`Host`] keeps them in ordinary
//!   memory as `Vec<T>`. Data structures made of buffers are generic over the
//!   memory and not over the backend, so that everything that works on one
//!   memory can share them.
//! * [`Backend`] makes buffers, [`Download`] reads them back. Handles that
//!   only record work for somebody else to submit are a `Backend` without
//!   being a `Download`: reading too early is then a compile error.
//! * [`Cpu`] is the backend that defines every result. It is always there.
//! * `gpu::Gpu` (feature `wgpu`) runs steps on a GPU: on the user's device, into
//!   the user's command encoder, or on an adapter that it picks itself.
//! * `shader` (feature `wgsl`) puts a shader together from parts that know
//!   nothing of each other; it is text, and needs no device.
//! * `testing` (feature `testing`) is for tests of steps: shaders checked
//!   without a device, layouts compared with Rust, a device or the reason why
//!   there is none.
//!
//! # A step for any backend
//!
//! A crate declares its steps as a trait on top of [`Backend`], implements it
//! for [`Cpu`], and writes its pipelines against the trait.
//!
//! ```
//! use gpu_backend::{Backend, BufferOf, Cpu, Download, Error};
//!
//! /// Optical depth to transmittance, T = exp(-tau).
//! trait Attenuate: Backend {
//!     fn attenuate(&self, tau: &BufferOf<Self, f32>) -> Result<BufferOf<Self, f32>, Error>;
//! }
//!
//! impl Attenuate for Cpu {
//!     fn attenuate(&self, tau: &Vec<f32>) -> Result<Vec<f32>, Error> {
//!         let mut out = self.zeros(tau.len())?;
//!         self.for_each_chunk(&mut out, 1024, |first, chunk: &mut [f32]| {
//!             for (t, tau) in chunk.iter_mut().zip(&tau[first..]) {
//!                 *t = (-tau).exp();
//!             }
//!         });
//!         Ok(out)
//!     }
//! }
//!
//! fn pipeline<B: Attenuate + Download>(backend: &B) -> Result<Vec<f32>, Error> {
//!     let tau = backend.upload(&[0.0, 1.0])?;
//!     let transmittance = backend.attenuate(&tau)?;
//!     backend.download(&transmittance)
//! }
//!
//! assert_eq!(pipeline(&Cpu::new())?[0], 1.0);
//! # Ok::<(), Error>(())
//! ```
//!
//! # Limits
//!
//! Element types are plain data ([`Element`]): no padding, any bit pattern
//! valid. A backend is chosen at compile time; it is not a `dyn` trait,
//! because its buffers are typed. Results never depend on the number of
//! threads.

mod cpu;
mod error;
#[cfg(feature = "wgpu")]
pub mod gpu;
#[cfg(feature = "wgsl")]
pub mod shader;
#[cfg(feature = "testing")]
pub mod testing;

pub use cpu::{Cpu, Host};
pub use error::Error;

use std::fmt::Debug;

/// Plain data that can be an element of a [`Buffer`] on any device.
///
/// Implemented for every type that qualifies; it is only a name for the bounds.
pub trait Element: bytemuck::Pod + Send + Sync + Debug {}

impl<T: bytemuck::Pod + Send + Sync + Debug> Element for T {}

/// A typed run of elements that lives on some device.
pub trait Buffer<T>: Debug + Send + Sync {
    /// Number of elements.
    fn len(&self) -> usize;

    /// True if there are no elements. An empty buffer is legal everywhere.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A family of buffer types that share one address space.
pub trait Memory: Debug + 'static {
    /// The buffer type for elements of type `T`.
    type Buffer<T: Element>: Buffer<T>;
}

/// The buffer type of backend `B` for elements of type `T`.
pub type BufferOf<B, T> = <<B as Backend>::Memory as Memory>::Buffer<T>;

/// Something that owns buffers and on which steps can run.
///
/// Methods take `&self`: a backend is a handle, and outputs of steps are
/// passed as `&mut` buffers so that aliasing is a compile error.
pub trait Backend {
    /// Where the buffers of this backend live.
    type Memory: Memory;

    /// A name for reports, such as `cpu` or the name of an adapter.
    fn name(&self) -> &str;

    /// Copies `data` into a new buffer.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the device cannot hold a buffer of that size.
    fn upload<T: Element>(&self, data: &[T]) -> Result<BufferOf<Self, T>, Error>;

    /// A new buffer of `len` elements whose bytes are all zero.
    ///
    /// # Errors
    /// [`Error::TooLarge`] if the device cannot hold a buffer of that size.
    fn zeros<T: Element>(&self, len: usize) -> Result<BufferOf<Self, T>, Error>;

    /// Fails if the device has gone. The CPU is always there.
    ///
    /// The error of a step may wrap that of another one. Whoever wants to know whether
    /// anything else can still run on the device asks this instead of unwrapping it.
    ///
    /// # Errors
    /// [`Error::DeviceLost`].
    fn check_alive(&self) -> Result<(), Error> {
        Ok(())
    }
}

/// A backend that can finish its work now and give the result back.
pub trait Download: Backend {
    /// Copies a buffer back, after all work that was issued before.
    ///
    /// # Errors
    /// Any error of the work that is still outstanding.
    fn download<T: Element>(&self, buffer: &BufferOf<Self, T>) -> Result<Vec<T>, Error>;

    /// Returns when all work issued so far is done; what a timing calls
    /// before it looks at the clock.
    ///
    /// # Errors
    /// Any error of the work that is still outstanding.
    fn wait(&self) -> Result<(), Error>;
}

/// The README's example is a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
pub struct Readme;
