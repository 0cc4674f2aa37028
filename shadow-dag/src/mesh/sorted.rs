//! Work on many things at once whose results are put into parts.

use gpu_backend::Cpu;

/// Parts into which things are put.
pub(super) const PARTS: usize = 64;

/// Things looked at in a row by one thread.
const RUN: usize = 1 << 14;

/// `each` of consecutive runs of `len` things, in order.
pub(super) fn runs<T: Send>(
    cpu: &Cpu,
    len: usize,
    each: impl Fn(std::ops::Range<usize>) -> T + Sync + Send,
) -> Vec<T> {
    cpu.map(len.div_ceil(RUN), |run| {
        each(run * RUN..len.min((run + 1) * RUN))
    })
}

/// The results of many things, sorted into parts.
#[derive(Debug)]
pub(super) struct Parts<T> {
    runs: Vec<Vec<Vec<T>>>,
}

impl<T: Send> Parts<T> {
    /// Of `len` things: `put` adds what becomes of a thing to any of the
    /// [`PARTS`] parts that it is given.
    pub(super) fn new(
        cpu: &Cpu,
        len: usize,
        put: impl Fn(usize, &mut [Vec<T>]) + Sync + Send,
    ) -> Self {
        let runs = runs(cpu, len, |things| {
            let mut parts: Vec<Vec<T>> = (0..PARTS).map(|_| Vec::new()).collect();
            for thing in things {
                put(thing, &mut parts);
            }
            parts
        });
        Self { runs }
    }

    /// The results that were put into a part, in the order of the things.
    pub(super) fn part(&self, part: usize) -> impl Iterator<Item = &T> {
        self.runs.iter().flat_map(move |run| &run[part])
    }

    /// How much that is.
    pub(super) fn len(&self, part: usize) -> usize {
        self.runs.iter().map(|run| run[part].len()).sum()
    }
}
