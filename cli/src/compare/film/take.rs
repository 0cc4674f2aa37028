//! All frames of a shot, made by one method.

use std::time::Instant;

use gpu_backend::{Download, Host};
use lighting::methods::{
    Frame, FrameInputs, Method, MethodBackend, MethodError, RunOn, Store, Used, forget_lights,
    share_film_frame,
};

use super::frames::Frames;
use super::path::Moved;
use super::{Filmed, Limit};
use crate::compare::prepare::Prepared;
use crate::compare::times::Times;

/// A method's film.
pub(super) struct Take {
    pub(super) pictures: Vec<Vec<[f32; 4]>>,
    /// Time of a frame with all that is made anew for it. The first frame does not count.
    pub(super) seconds: Times,
    /// How many things were made for frames, and how many of earlier frames were used again,
    /// also in frames in front of the film.
    pub(super) made: usize,
    pub(super) reused: usize,
}

impl Take {
    /// Makes the film; the inner error says why it is not complete.
    ///
    /// # Errors
    /// The errors of the method.
    #[expect(
        clippy::too_many_arguments,
        reason = "two stores, which the CPU has as one"
    )]
    pub(super) fn new<B: MethodBackend + Download>(
        backend: &B,
        store: &Store<B::Memory>,
        host: &Store<Host>,
        prepared: &Prepared,
        frames: &Frames,
        filmed: &Filmed,
        limit: Limit<'_>,
        tick: &dyn Fn(),
    ) -> Result<Result<Self, String>, MethodError> {
        let job = prepared.job(false).expect("a film has light");
        let method: &dyn RunOn<B> = &filmed.entry;
        let mut take = Self {
            pictures: Vec::new(),
            seconds: Times::of(&[0.0]),
            made: 0,
            reused: 0,
        };
        let mut known: Vec<Used> = Vec::new();
        let mut times = Vec::new();
        // A method that remembers frames goes through the shot once before it is measured, as
        // if the film had gone on for long.
        let before = match filmed.entry.remembers_frames() {
            true => frames.all.len(),
            false => 0,
        };
        let all = frames.all.iter().cycle().take(before + frames.all.len());
        for (index, scenery) in all.enumerate() {
            let rest = (before + frames.all.len() - index) as f64;
            let expected = times.last().map_or(0.0, |seconds| rest * seconds);
            if let Some(why) = limit.reached_after(expected) {
                return Ok(Err(why));
            }
            if frames.moved == Moved::Lights {
                forget_lights(host);
                forget_lights(store);
            }
            share_film_frame(host, index as u32);
            store.watch_use();
            host.watch_use();
            let inputs = FrameInputs {
                host,
                ..scenery.job(job, frames.size).inputs(&())
            };
            let clock = Instant::now();
            let frame = Frame::new(backend, inputs, store)?;
            method.prepare(&frame, filmed.quality)?;
            let mut radiance = backend.zeros(inputs.rays.len())?;
            method.add_radiance(&frame, filmed.quality, &mut radiance)?;
            let picture = backend.download(&radiance)?;
            times.push(clock.elapsed().as_secs_f64());
            take.count(&mut known, store.used(), host.used());
            if index >= before {
                take.pictures.push(picture);
                tick();
            }
        }
        take.seconds = Times::of(times.get(1..).unwrap_or(&times));
        Ok(Ok(take))
    }

    /// Counts what was made and what was used again.
    fn count(&mut self, known: &mut Vec<Used>, store: Vec<Used>, host: Vec<Used>) {
        let mut now: Vec<Used> = Vec::new();
        for used in store.into_iter().chain(host) {
            // Things that were put into the store from outside took no time.
            let is_made = used.seconds > 0.0;
            if !is_made || now.contains(&used) {
                continue;
            }
            match known.contains(&used) {
                true => self.reused += 1,
                false => self.made += 1,
            }
            now.push(used);
        }
        for used in now {
            if !known.contains(&used) {
                known.push(used);
            }
        }
    }
}
