//! For tests of steps and shaders.
//!
//! [`Shader`] checks WGSL on any machine, without a device, and compares it
//! with Rust and with its own documentation. `gpu` (feature `wgpu`) is the device for a
//! test, or a printed reason why the test does nothing.
//!
//! ```
//! use gpu_backend::{assert_same_layout, testing::Shader};
//!
//! const WGSL: &str = "
//!     struct fog_Medium { sigma_s: vec3<f32>, g: f32, sigma_t: vec3<f32>, far: f32 }
//!     const fog_STEPS: u32 = 64;
//!     fn fog_phase(medium: fog_Medium) -> f32 { return 1.0 - medium.g; }
//! ";
//!
//! #[repr(C)]
//! struct Medium { sigma_s: [f32; 3], g: f32, sigma_t: [f32; 3], far: f32 }
//! const STEPS: u32 = 64;
//!
//! let shader = Shader::new(&[WGSL])?;
//! shader.require_part(&["fog_"])?;
//! assert_same_layout!(shader, "fog_Medium", Medium { sigma_s, g, sigma_t, far });
//! assert_eq!(shader.values("fog_STEPS")?, [f64::from(STEPS)]);
//! # Ok::<(), gpu_backend::testing::ShaderError>(())
//! ```

#[cfg(feature = "wgpu")]
mod device;
mod documented;
mod shader;

#[cfg(feature = "wgpu")]
pub use device::gpu;
pub use shader::{Member, Shader, ShaderError, StructLayout};
