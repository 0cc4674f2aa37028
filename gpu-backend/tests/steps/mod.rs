//! Steps whose results depend on everything that could go wrong: the index, the
//! value, the parameters, and the order.

use gpu_backend::gpu::{Argument, Encode, Gpu, GpuBuffer, INDEX_WGSL, Kernel, Workgroups};
use gpu_backend::{Backend, Buffer, BufferOf, Cpu, Error};

/// Invocations per workgroup.
pub(crate) const GROUP: u32 = 64;

/// What the step computes for one element.
pub(crate) fn scramble(index: u32, value: u32, key: u32) -> u32 {
    (value ^ index.rotate_left(7)).wrapping_mul(2_654_435_761) ^ key
}

const SHADER: &str = include_str!("steps.wgsl");

pub(crate) const SCRAMBLE: Kernel<'_> = Kernel {
    label: "scramble",
    parts: &[SHADER, INDEX_WGSL],
    entry: "scramble",
    constants: &[],
};

pub(crate) const ADD: Kernel<'_> = Kernel {
    label: "add",
    parts: &[INDEX_WGSL, SHADER],
    entry: "add",
    constants: &[],
};

pub(crate) const NOTHING: Kernel<'_> = Kernel {
    label: "do nothing",
    parts: &["@compute @workgroup_size(1) fn main() {}"],
    entry: "main",
    constants: &[],
};

#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Parameters {
    count: u32,
    key: u32,
}

pub(crate) trait Steps: Backend {
    fn scramble(&self, data: &BufferOf<Self, u32>, key: u32) -> Result<BufferOf<Self, u32>, Error>;

    /// Adds `key` to every element, in place.
    fn add(&self, data: &mut BufferOf<Self, u32>, key: u32) -> Result<(), Error>;
}

impl Steps for Cpu {
    fn scramble(&self, data: &Vec<u32>, key: u32) -> Result<Vec<u32>, Error> {
        Ok(self.map(data.len(), |i| scramble(i as u32, data[i], key)))
    }

    fn add(&self, data: &mut Vec<u32>, key: u32) -> Result<(), Error> {
        self.for_each_chunk(data, 1024, |_, chunk| {
            chunk.iter_mut().for_each(|v| *v = v.wrapping_add(key));
        });
        Ok(())
    }
}

fn parameters(data: &GpuBuffer<u32>, key: u32) -> Argument<'static> {
    Argument::uniform(Parameters {
        count: data.len() as u32,
        key,
    })
}

impl<E: Encode> Steps for Gpu<E> {
    fn scramble(&self, data: &GpuBuffer<u32>, key: u32) -> Result<GpuBuffer<u32>, Error> {
        let mut out = self.zeros(data.len())?;
        self.dispatch(
            &SCRAMBLE,
            &[&[
                parameters(data, key),
                Argument::write(&mut out),
                Argument::read(data),
            ]],
            Workgroups::covering(data.len(), GROUP),
        )?;
        Ok(out)
    }

    fn add(&self, data: &mut GpuBuffer<u32>, key: u32) -> Result<(), Error> {
        let parameters = parameters(data, key);
        let groups = Workgroups::covering(data.len(), GROUP);
        self.dispatch(&ADD, &[&[parameters, Argument::write(data)]], groups)
    }
}
