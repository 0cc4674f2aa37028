//! The backend that defines every result: ordinary memory and threads.

use crate::{Backend, Buffer, BufferOf, Download, Element, Error, Memory};

/// Ordinary memory; buffers are `Vec<T>`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Host;

impl Memory for Host {
    type Buffer<T: Element> = Vec<T>;
}

impl<T: Element> Buffer<T> for Vec<T> {
    fn len(&self) -> usize {
        Vec::len(self)
    }
}

/// Runs steps on the processor.
///
/// With the feature `rayon` (default) work is spread over threads, without it
/// everything runs on the calling one. Either way the results are identical
/// bit for bit, because every element is computed independently of how the
/// elements are divided.
#[derive(Debug, Default)]
pub struct Cpu {
    #[cfg(feature = "rayon")]
    threads: Threads,
}

#[cfg(feature = "rayon")]
#[derive(Debug, Default)]
enum Threads {
    /// The calling thread only.
    Calling,
    /// Rayon's global pool, or the pool the caller is running in.
    #[default]
    Ambient,
    /// A pool of our own.
    Own(rayon::ThreadPool),
}

/// Steps are behind a pointer here: the compiler makes the machinery of parallel iterators once
/// for each type of element instead of once for each step, of which there are hundreds.
#[cfg(feature = "rayon")]
impl Threads {
    fn for_each_chunk<T: Send>(
        &self,
        out: &mut [T],
        chunk_len: usize,
        step: &(dyn Fn(usize, &mut [T]) + Sync),
    ) {
        use rayon::prelude::*;
        self.run(|| {
            out.par_chunks_mut(chunk_len)
                .enumerate()
                .for_each(|(index, chunk)| step(index * chunk_len, chunk));
        });
    }

    fn map<T: Send>(&self, len: usize, step: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
        use rayon::prelude::*;
        let mut all = Vec::new();
        self.run(|| {
            (0..len)
                .into_par_iter()
                .map(step)
                .collect_into_vec(&mut all);
        });
        all
    }

    fn run(&self, parallel: impl FnOnce() + Send) {
        match self {
            Self::Own(pool) => pool.install(parallel),
            Self::Calling | Self::Ambient => parallel(),
        }
    }
}

impl Cpu {
    /// All the threads there are (one without the feature `rayon`).
    pub fn new() -> Self {
        Self::default()
    }

    /// Only the calling thread.
    pub fn single_threaded() -> Self {
        Self {
            #[cfg(feature = "rayon")]
            threads: Threads::Calling,
        }
    }

    /// A pool of exactly `threads` threads; 0 means one per core.
    ///
    /// # Errors
    /// [`Error::Threads`] if the system cannot start them.
    #[cfg(feature = "rayon")]
    pub fn with_threads(threads: usize) -> Result<Self, Error> {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .map(|pool| Self {
                threads: Threads::Own(pool),
            })
            .map_err(|error| Error::Threads {
                threads,
                reason: error.to_string(),
            })
    }

    /// Calls `step(first, chunk)` for consecutive chunks of `out`, each of
    /// `chunk_len` elements but for the last; `first` is the index of the
    /// chunk's first element. Chunks run in any order and on any thread.
    ///
    /// A `chunk_len` of 0 counts as 1; an empty `out` calls nothing.
    pub fn for_each_chunk<T, F>(&self, out: &mut [T], chunk_len: usize, step: F)
    where
        T: Send,
        F: Fn(usize, &mut [T]) + Sync,
    {
        let chunk_len = chunk_len.max(1);
        #[cfg(feature = "rayon")]
        if !matches!(self.threads, Threads::Calling) {
            return self.threads.for_each_chunk(out, chunk_len, &step);
        }
        for (index, chunk) in out.chunks_mut(chunk_len).enumerate() {
            step(index * chunk_len, chunk);
        }
    }

    /// `(0..len).map(step)` collected in order, computed on any thread.
    pub fn map<T, F>(&self, len: usize, step: F) -> Vec<T>
    where
        T: Send,
        F: Fn(usize) -> T + Sync + Send,
    {
        #[cfg(feature = "rayon")]
        if !matches!(self.threads, Threads::Calling) {
            return self.threads.map(len, &step);
        }
        (0..len).map(step).collect()
    }
}

impl Backend for Cpu {
    type Memory = Host;

    fn name(&self) -> &str {
        "cpu"
    }

    fn upload<T: Element>(&self, data: &[T]) -> Result<BufferOf<Self, T>, Error> {
        let mut buffer = reserve(data.len())?;
        buffer.extend_from_slice(data);
        Ok(buffer)
    }

    fn zeros<T: Element>(&self, len: usize) -> Result<BufferOf<Self, T>, Error> {
        let mut buffer = reserve(len)?;
        buffer.resize(len, T::zeroed());
        Ok(buffer)
    }
}

impl Download for Cpu {
    fn download<T: Element>(&self, buffer: &BufferOf<Self, T>) -> Result<Vec<T>, Error> {
        self.upload(buffer)
    }

    fn wait(&self) -> Result<(), Error> {
        Ok(())
    }
}

/// An empty vector with room for `len` elements, or the reason why not.
fn reserve<T: Element>(len: usize) -> Result<Vec<T>, Error> {
    let mut buffer = Vec::new();
    match buffer.try_reserve_exact(len) {
        Ok(()) => Ok(buffer),
        Err(_) => Err(Error::TooLarge {
            what: "a buffer",
            requested: (len as u64).saturating_mul(size_of::<T>() as u64),
            limit: isize::MAX as u64,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_absurd_length_is_an_error() {
        let error = Cpu::new().zeros::<[f32; 4]>(usize::MAX / 2).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    }

    #[test]
    fn chunks_cover_everything_once_and_in_place() {
        for cpu in [Cpu::new(), Cpu::single_threaded()] {
            for (len, chunk) in [(0, 4), (1, 4), (7, 3), (8, 0), (9, 100)] {
                let mut out = vec![0_usize; len];
                cpu.for_each_chunk(&mut out, chunk, |first, chunk| {
                    for (offset, value) in chunk.iter_mut().enumerate() {
                        *value += first + offset + 1;
                    }
                });
                assert_eq!(out, (1..=len).collect::<Vec<_>>());
                assert_eq!(cpu.map(len, |i| i + 1), out);
            }
        }
    }

    #[test]
    fn buffers_come_back_as_they_went() -> Result<(), Error> {
        let cpu = Cpu::single_threaded();
        let up = cpu.upload(&[1_u32, 2, 3])?;
        assert_eq!(cpu.download(&up)?, [1, 2, 3]);
        assert_eq!(
            cpu.download(&cpu.zeros::<u8>(0)?)?,
            Vec::<u8>::new(),
            "empty is legal"
        );
        cpu.wait()
    }
}
