//! Compute kernels: assembled from text, built once, dispatched anywhere.

use super::argument::{self, Kind};
use super::{Argument, Context, Encode, Gpu, lock};
use crate::Error;

/// WGSL of `gpu_index`, the number of an invocation in a dispatch of
/// [`Workgroups::covering`].
pub const INDEX_WGSL: &str = include_str!("index.wgsl");

/// A compute shader, by its source.
///
/// The parts are joined with line breaks, in any order. They are `'static`
/// because a kernel is looked up by where its text is, which is fast, and not
/// by what it says: text that is only known at run time must be leaked, once.
#[derive(Debug, Clone, Copy)]
pub struct Kernel<'a> {
    /// For error messages and debuggers.
    pub label: &'static str,
    /// WGSL; together one module.
    pub parts: &'a [&'static str],
    /// Name of the `@compute` function.
    pub entry: &'static str,
    /// Values of `override` declarations.
    pub constants: &'a [(&'static str, f64)],
}

/// How many workgroups a dispatch has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Workgroups {
    /// Enough groups of `size` invocations for `items`, folded into rows if
    /// one dimension does not hold them; see [`INDEX_WGSL`].
    Covering {
        /// Invocations that have work.
        items: usize,
        /// Invocations per group, the product of `@workgroup_size`.
        size: u32,
    },
    /// Exactly these.
    Grid([u32; 3]),
}

impl Workgroups {
    /// Enough groups of `size` invocations (0 counts as 1) for `items`.
    pub const fn covering(items: usize, size: u32) -> Self {
        Self::Covering { items, size }
    }

    /// Groups per dimension; `None` if there is nothing to do.
    fn resolve(self, what: &'static str, limit: u32) -> Result<Option<[u32; 3]>, Error> {
        let too_many = |requested: u64, limit: u32| Error::Limit {
            what,
            unit: "workgroups in one dimension",
            requested,
            limit: u64::from(limit),
        };
        let grid = match self {
            Self::Grid(grid) => {
                if let Some(count) = grid.into_iter().find(|count| *count > limit) {
                    return Err(too_many(u64::from(count), limit));
                }
                grid
            }
            Self::Covering { items, size } => {
                let size = u64::from(size.max(1));
                let most = u64::from(limit);
                let groups = (items as u64).div_ceil(size);
                let rows = groups.div_ceil(most.max(1));
                let columns = groups.div_ceil(rows.max(1));
                if rows.max(columns) > most {
                    return Err(too_many(groups, limit));
                }
                let invocations = (rows * columns).saturating_mul(size);
                // The index is a u32.
                if invocations > u64::from(u32::MAX) {
                    return Err(Error::Limit {
                        what,
                        unit: "invocations",
                        requested: invocations,
                        limit: u64::from(u32::MAX),
                    });
                }
                // Neither exceeds `limit`, a u32.
                [columns as u32, rows as u32, 1]
            }
        };
        Ok((!grid.contains(&0)).then_some(grid))
    }
}

/// A kernel that is ready to run.
struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    /// `None` for groups without bindings.
    layouts: Vec<Option<wgpu::BindGroupLayout>>,
}

/// Texts are compared by where they are. They are `'static`, so the same place
/// and length always hold the same text.
type Address = (usize, usize);

#[derive(PartialEq, Eq, Hash)]
struct Key {
    parts: Vec<Address>,
    entry: &'static str,
    constants: Vec<(&'static str, u64)>,
    kinds: Vec<Vec<Kind>>,
}

impl<E: Encode> Gpu<E> {
    /// Records one dispatch of `kernel`. The arguments are the bindings: the
    /// `i`-th of the `g`-th list is `@group(g) @binding(i)`. Several groups let
    /// independent parts of an assembled shader number theirs from 0.
    ///
    /// If there are no workgroups nothing is recorded. The pipeline is built
    /// on first use and kept in the [`Context`].
    ///
    /// # Errors
    /// Before anything is recorded: [`Error::Limit`] for too many workgroups or
    /// bindings, [`Error::TooLarge`] for a buffer that cannot be bound whole,
    /// [`Error::Aliased`] if a written buffer is given twice,
    /// [`Error::Rejected`] if the shader does not compile or its bindings are
    /// not those given, [`Error::DeviceLost`], [`Error::OutOfMemory`].
    pub fn dispatch(
        &self,
        kernel: &Kernel<'_>,
        groups: &[&[Argument<'_>]],
        workgroups: Workgroups,
    ) -> Result<(), Error> {
        let context = &self.context;
        let label = kernel.label;
        argument::check(context, label, groups)?;
        let limit = context.limits().max_compute_workgroups_per_dimension;
        let Some([x, y, z]) = workgroups.resolve(label, limit)? else {
            return context.check_alive();
        };
        let pipeline = context.cached(label, Key::new(kernel, groups), |_| {
            Ok(build(context, kernel, groups))
        })?;
        let bind_groups = pipeline
            .layouts
            .iter()
            .zip(groups)
            .map(|(layout, arguments)| {
                layout
                    .as_ref()
                    .map(|layout| context.bind_checked(label, layout, arguments))
                    .transpose()
            })
            .collect::<Result<Vec<_>, Error>>()?;
        if bind_groups.iter().all(Option::is_none) {
            context.check_alive()?;
        }
        self.with_encoder(label, |encoder| {
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(label),
                timestamp_writes: None,
            });
            pass.set_pipeline(&pipeline.pipeline);
            for (index, group) in (0..).zip(&bind_groups) {
                if let Some(group) = group {
                    pass.set_bind_group(index, group, &[]);
                }
            }
            pass.dispatch_workgroups(x, y, z);
        })?;
        lock(&self.statistics).dispatches += 1;
        Ok(())
    }
}

impl Key {
    fn new(kernel: &Kernel<'_>, groups: &[&[Argument<'_>]]) -> Self {
        Self {
            parts: kernel
                .parts
                .iter()
                .map(|part| (part.as_ptr().addr(), part.len()))
                .collect(),
            entry: kernel.entry,
            constants: kernel
                .constants
                .iter()
                .map(|(name, value)| (*name, value.to_bits()))
                .collect(),
            kinds: groups
                .iter()
                .map(|group| group.iter().map(Argument::kind).collect())
                .collect(),
        }
    }
}

fn build(context: &Context, kernel: &Kernel<'_>, groups: &[&[Argument<'_>]]) -> Pipeline {
    let device = context.device();
    let label = Some(kernel.label);
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        // A part may end in a comment.
        source: wgpu::ShaderSource::Wgsl(kernel.parts.join("\n").into()),
    });
    let stages = wgpu::ShaderStages::COMPUTE;
    let layouts: Vec<_> = groups
        .iter()
        .map(|group| {
            (!group.is_empty()).then(|| context.bind_group_layout(kernel.label, stages, group))
        })
        .collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &layouts.iter().map(Option::as_ref).collect::<Vec<_>>(),
        immediate_size: 0,
    });
    Pipeline {
        pipeline: device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label,
            layout: Some(&layout),
            module: &module,
            entry_point: Some(kernel.entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: kernel.constants,
                ..wgpu::PipelineCompilationOptions::default()
            },
            cache: None,
        }),
        layouts,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn covering(items: usize, size: u32, limit: u32) -> Result<Option<[u32; 3]>, Error> {
        Workgroups::covering(items, size).resolve("a test", limit)
    }

    #[test]
    fn workgroups_cover_all_items_and_little_more() {
        assert_eq!(covering(0, 64, 65535), Ok(None));
        assert_eq!(covering(1, 64, 65535), Ok(Some([1, 1, 1])));
        assert_eq!(covering(65, 64, 65535), Ok(Some([2, 1, 1])));
        assert_eq!(covering(5, 0, 65535), Ok(Some([5, 1, 1])));
        for (items, size, limit) in [(65536, 1, 65535), (1000, 3, 20), (7, 1, 3), (400, 1, 20)] {
            let [x, y, z] = covering(items, size, limit).unwrap().unwrap();
            let invocations = x as usize * y as usize * size as usize;
            assert!(x <= limit && y <= limit && z == 1);
            assert!(invocations >= items && invocations - items < (y * size) as usize);
        }
    }

    #[test]
    fn more_than_fit_are_an_error_that_names_the_limit() {
        assert!(matches!(
            covering(401, 1, 20),
            Err(Error::Limit {
                requested: 401,
                limit: 20,
                ..
            })
        ));
        assert!(matches!(
            covering(usize::MAX, 1, 65535),
            Err(Error::Limit { .. })
        ));
        assert!(matches!(
            Workgroups::Grid([1, 70_000, 1]).resolve("a test", 65535),
            Err(Error::Limit {
                requested: 70_000,
                ..
            })
        ));
        assert_eq!(
            Workgroups::Grid([4, 0, 1]).resolve("a test", 65535),
            Ok(None)
        );
    }
}
