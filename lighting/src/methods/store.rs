//! What methods share, and what stays between frames.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::fmt::{self, Debug};
use std::hash::Hash;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use gpu_backend::{Error, Memory};

use super::MethodError;

/// Shadow maps, voxels, precomputed shadows and tables, by key. Each is made when it is first
/// asked for, and all methods share it.
///
/// A store belongs to one scene and to the memory of one backend. It keeps what it was given as
/// long as it lives, and counts the time and the bytes of everything. It does not notice
/// changes of the scene: call [`forget_lights`](super::forget_lights) when lights have moved
/// and [`forget_dynamic`](super::forget_dynamic) when dynamic casters have, or shadows stay
/// where they were.
///
/// On a GPU that records into an encoder of yours, a store keeps things from the moment they are
/// recorded. Submit what was recorded. If you drop the encoder instead, make a new store: later
/// frames would read zeros from what the old one keeps.
pub struct Store<M: Memory> {
    shelves: Mutex<Shelves>,
    wait: Option<Wait>,
    memory: PhantomData<fn() -> M>,
}

/// Waits until the backend has done its work.
type Wait = Box<dyn Fn() -> Result<(), Error> + Send + Sync>;

#[derive(Default)]
struct Shelves {
    /// One shelf for each pair of a key's type and a value's type.
    by_type: HashMap<TypeId, Shelf>,
    /// For each thing that is being made, the outermost first: the seconds spent so far on the
    /// other things that it asked for.
    nested: Vec<f64>,
    /// What was handed out since [`Store::watch_use`].
    used: Vec<Used>,
    made: usize,
}

struct Shelf {
    /// The type of the keys.
    key: TypeId,
    /// A `HashMap<K, Kept<T>>`.
    things: Box<dyn Any + Send>,
}

struct Kept<T> {
    value: Arc<T>,
    used: Used,
}

/// A record of something that a store has handed out.
#[derive(Debug, Clone, PartialEq)]
pub struct Used {
    /// What it is.
    pub what: &'static str,
    /// Seconds that it took to make, without those of the things that it is made from.
    pub seconds: f64,
    /// Memory, bytes.
    pub bytes: u64,
    /// Distinguishes the things in one store.
    id: usize,
}

impl<M: Memory> Default for Store<M> {
    fn default() -> Self {
        Self {
            shelves: Mutex::default(),
            wait: None,
            memory: PhantomData,
        }
    }
}

impl<M: Memory> Debug for Store<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let made = self.lock().made;
        f.debug_struct("Store").field("made", &made).finish()
    }
}

impl<M: Memory> Store<M> {
    /// An empty store.
    pub fn new() -> Self {
        Self::default()
    }

    /// An empty store that waits until each thing is finished, so that times are true on
    /// backends that work asynchronously.
    pub fn waiting(wait: impl Fn() -> Result<(), Error> + Send + Sync + 'static) -> Self {
        Self {
            wait: Some(Box::new(wait)),
            ..Self::default()
        }
    }

    /// The value for a key; it is made now if there is none. `what` names its kind, and `bytes`
    /// returns its size.
    ///
    /// `make` may ask the store for other things.
    ///
    /// # Errors
    /// Those of `make`.
    pub fn get<K, T>(
        &self,
        what: &'static str,
        key: K,
        bytes: impl FnOnce(&T) -> u64,
        make: impl FnOnce() -> Result<T, MethodError>,
    ) -> Result<Arc<T>, MethodError>
    where
        K: Eq + Hash + Send + 'static,
        T: Send + Sync + 'static,
    {
        if let Some(found) = self.find(&key) {
            return Ok(found);
        }
        self.lock().nested.push(0.0);
        let clock = Instant::now();
        let made = make().and_then(|value| {
            self.wait()?;
            Ok(value)
        });
        let all = clock.elapsed().as_secs_f64();
        let mut shelves = self.lock();
        let seconds = all - shelves.nested.pop().unwrap_or(0.0);
        if let Some(outer) = shelves.nested.last_mut() {
            *outer += all;
        }
        drop(shelves);
        let value = made?;
        let bytes = bytes(&value);
        Ok(self.put(key, Arc::new(value), what, seconds, bytes))
    }

    /// Puts in a value that was made elsewhere; it replaces one with the same key.
    pub fn insert<K, T>(&self, what: &'static str, key: K, value: Arc<T>, bytes: u64)
    where
        K: Eq + Hash + Send + 'static,
        T: Send + Sync + 'static,
    {
        self.put(key, value, what, 0.0, bytes);
    }

    /// The value for a key, if there is one.
    pub(super) fn find<K, T>(&self, key: &K) -> Option<Arc<T>>
    where
        K: Eq + Hash + Send + 'static,
        T: Send + Sync + 'static,
    {
        let mut shelves = self.lock();
        let shelf = shelves.by_type.get(&TypeId::of::<(K, T)>())?;
        let shelf = shelf.things.downcast_ref::<HashMap<K, Kept<T>>>()?;
        let Kept { value, used } = shelf.get(key)?;
        let (value, used) = (value.clone(), used.clone());
        shelves.note(used);
        Some(value)
    }

    fn put<K, T>(
        &self,
        key: K,
        value: Arc<T>,
        what: &'static str,
        seconds: f64,
        bytes: u64,
    ) -> Arc<T>
    where
        K: Eq + Hash + Send + 'static,
        T: Send + Sync + 'static,
    {
        let mut shelves = self.lock();
        let used = Used {
            what,
            seconds,
            bytes,
            id: shelves.made,
        };
        shelves.made += 1;
        shelves.note(used.clone());
        let shelf = shelves.by_type.entry(TypeId::of::<(K, T)>());
        let shelf = shelf.or_insert_with(|| Shelf {
            key: TypeId::of::<K>(),
            things: Box::new(HashMap::<K, Kept<T>>::new()),
        });
        if let Some(shelf) = shelf.things.downcast_mut::<HashMap<K, Kept<T>>>() {
            let value = value.clone();
            shelf.insert(key, Kept { value, used });
        }
        value
    }

    /// Forgets everything except what has a key of one of these types.
    pub(super) fn keep_only(&self, keys: &[TypeId]) {
        (self.lock().by_type).retain(|_, shelf| keys.contains(&shelf.key));
    }

    /// Starts a new record of what is handed out; see [`Store::used`].
    pub fn watch_use(&self) {
        self.lock().used.clear();
    }

    /// What was handed out since [`Store::watch_use`], each thing once.
    pub fn used(&self) -> Vec<Used> {
        self.lock().used.clone()
    }

    /// Waits until the backend has done all that was issued, if the store
    /// [waits](Store::waiting) at all.
    ///
    /// # Errors
    /// Those of the work that is waited for.
    pub fn wait(&self) -> Result<(), MethodError> {
        match &self.wait {
            Some(wait) => Ok(wait()?),
            None => Ok(()),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Shelves> {
        // A panic leaves nothing half-changed under this lock.
        self.shelves.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shelves {
    fn note(&mut self, used: Used) {
        if self.used.iter().all(|other| other.id != used.id) {
            self.used.push(used);
        }
    }
}

#[cfg(test)]
mod tests {
    use gpu_backend::Host;

    use super::*;

    #[test]
    fn things_are_made_once_and_known_by_key_and_type() {
        let store = Store::<Host>::new();
        let get = |key: u32, value: u64| {
            store
                .get("a number", key, |_: &u64| 8, || Ok(value))
                .map(|found| *found)
                .unwrap()
        };
        assert_eq!((get(1, 10), get(2, 20), get(1, 30)), (10, 20, 10));
        let text = store.get("a text", 1_u32, |_: &String| 3, || Ok("abc".to_owned()));
        assert_eq!(*text.unwrap(), "abc");
        let used: Vec<_> = store.used().iter().map(|u| (u.what, u.bytes)).collect();
        assert_eq!(used, [("a number", 8), ("a number", 8), ("a text", 3)]);
        store.watch_use();
        assert_eq!((get(2, 0), store.used().len()), (20, 1));
    }

    #[test]
    fn what_is_made_from_other_things_counts_its_own_time() {
        let store = Store::<Host>::new();
        let pause = std::time::Duration::from_millis(20);
        store
            .get(
                "outer",
                0_u32,
                |_: &u32| 0,
                || {
                    let inner = store.get(
                        "inner",
                        1_u8,
                        |_: &u32| 0,
                        || {
                            std::thread::sleep(pause);
                            Ok(1)
                        },
                    )?;
                    Ok(*inner + 1)
                },
            )
            .unwrap();
        let used = store.used();
        let seconds = |what| used.iter().find(|u| u.what == what).unwrap().seconds;
        assert!(seconds("inner") >= pause.as_secs_f64());
        assert!(seconds("outer") >= 0.0);
        assert_eq!(used.len(), 2);
    }

    #[test]
    fn what_cannot_be_made_is_tried_again() {
        let store = Store::<Host>::new();
        let fails =
            || -> Result<u32, MethodError> { Err(MethodError::Stopped { done: 0, total: 1 }) };
        assert!(store.get("nothing", 0_u32, |_: &u32| 0, fails).is_err());
        let found = store.get("something", 0_u32, |_: &u32| 0, || Ok(7));
        assert_eq!(*found.unwrap(), 7);
    }
}
