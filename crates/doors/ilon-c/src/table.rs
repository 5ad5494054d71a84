//! Tables of the objects behind handles. A handle is a slot in a table and the slot's generation,
//! so that a freed handle is detected.

use std::sync::{Arc, Mutex, PoisonError, RwLock, TryLockError};

use crate::status::{Fault, IlonStatus};

/// Number of times that a slot is filled before it is retired: as many as a handle can hold.
const GENERATIONS: u32 = 1 << 24;

/// Objects by handle. A handle is the table's kind, the generation of a slot, and the slot counted
/// from 1, so that none is 0.
pub(crate) struct Table<T> {
    kind: u8,
    /// The kind of object, as named to callers.
    name: &'static str,
    places: RwLock<Places<T>>,
}

struct Places<T> {
    all: Vec<Place<T>>,
    free: Vec<u32>,
}

struct Place<T> {
    generation: u32,
    held: Option<Arc<Mutex<T>>>,
}

impl<T> Table<T> {
    pub const fn new(kind: u8, name: &'static str) -> Self {
        Self {
            kind,
            name,
            places: RwLock::new(Places {
                all: Vec::new(),
                free: Vec::new(),
            }),
        }
    }

    fn handle(&self, generation: u32, index: u32) -> u64 {
        (u64::from(self.kind) << 56) | (u64::from(generation) << 32) | (u64::from(index) + 1)
    }

    /// Adds an object and returns its handle.
    pub fn insert(&self, value: T) -> u64 {
        let held = Some(Arc::new(Mutex::new(value)));
        // A poisoned lock is safe: no panic can occur between two changes.
        let mut places = self.places.write().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = places.free.pop() {
            let place = &mut places.all[index as usize];
            place.held = held;
            return self.handle(place.generation, index);
        }
        let index =
            u32::try_from(places.all.len()).expect("billions of handles do not fit into memory");
        places.all.push(Place {
            generation: 1,
            held,
        });
        self.handle(1, index)
    }

    fn unknown(&self) -> Fault {
        let name = self.name;
        Fault::new(
            IlonStatus::Handle,
            format!("this is the handle of no {name}: it was freed, or never given"),
        )
    }

    fn is_in(&self, place: &Place<T>, index: u32, handle: u64) -> bool {
        self.handle(place.generation, index) == handle && place.held.is_some()
    }

    /// Runs `act` on the object of a handle.
    pub fn with<R>(
        &self,
        handle: u64,
        act: impl FnOnce(&mut T) -> Result<R, Fault>,
    ) -> Result<R, Fault> {
        let held = {
            let index = (handle as u32).wrapping_sub(1);
            let places = self.places.read().unwrap_or_else(PoisonError::into_inner);
            let place = places.all.get(index as usize);
            let place = place.filter(|place| self.is_in(place, index, handle));
            place
                .and_then(|place| place.held.clone())
                .ok_or_else(|| self.unknown())?
        };
        match held.try_lock() {
            Ok(mut value) => act(&mut value),
            Err(TryLockError::WouldBlock) => Err(Fault::new(
                IlonStatus::Busy,
                format!("another thread is using this {}", self.name),
            )),
            Err(TryLockError::Poisoned(_)) => Err(Fault::new(
                IlonStatus::Internal,
                format!(
                    "this {} is in an unknown state after a fault of ilon itself: free it",
                    self.name
                ),
            )),
        }
    }

    /// Removes the object of a handle. A thread that is using it finishes its call.
    pub fn remove(&self, handle: u64) -> Result<(), Fault> {
        let index = (handle as u32).wrapping_sub(1);
        let mut places = self.places.write().unwrap_or_else(PoisonError::into_inner);
        let place = places.all.get_mut(index as usize);
        let place = place.filter(|place| self.is_in(place, index, handle));
        let place = place.ok_or_else(|| self.unknown())?;
        let held = place.held.take();
        place.generation += 1;
        if place.generation < GENERATIONS {
            places.free.push(index);
        }
        drop(places);
        // Outside the lock, as dropping may take time.
        drop(held);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_handle_that_was_freed_is_refused_for_ever_and_places_are_used_again() {
        let table = Table::new(1, "number");
        let first = table.insert(1);
        assert_eq!(table.with(first, |x| Ok(*x)).unwrap(), 1);
        table.remove(first).unwrap();
        for _ in 0..1000 {
            let next = table.insert(2);
            let refused = table.with(first, |x| Ok(*x)).unwrap_err();
            assert_eq!(refused.status, IlonStatus::Handle);
            assert_eq!(table.remove(first).unwrap_err().status, IlonStatus::Handle);
            table.remove(next).unwrap();
        }
        assert_eq!(table.places.read().unwrap().all.len(), 1);
    }

    #[test]
    fn what_was_never_given_or_is_of_another_kind_is_refused() {
        let (numbers, others) = (Table::new(1, "number"), Table::new(2, "other"));
        let (number, other) = (numbers.insert(1), others.insert(1));
        for wrong in [0, 1, other, number + 1, number + (1 << 32), u64::MAX] {
            assert!(numbers.with(wrong, |_| Ok(())).is_err(), "{wrong:x}");
            assert!(numbers.remove(wrong).is_err(), "{wrong:x}");
        }
    }

    /// The last generation of a slot does not overflow into the kind.
    #[test]
    fn a_place_that_was_filled_too_often_is_left_alone() {
        let table = Table::new(1, "number");
        let first = table.insert(0);
        table.places.write().unwrap().all[0].generation = GENERATIONS - 1;
        let last = table.handle(GENERATIONS - 1, 0);
        assert_eq!(last >> 56, 1);
        table.remove(last).unwrap();
        let next = table.insert(0);
        assert_ne!(next as u32, first as u32);
    }

    #[test]
    fn two_threads_at_once_are_refused_and_not_mixed() {
        let table = Table::new(1, "number");
        let handle = table.insert(0);
        let busy = table
            .with(handle, |_| {
                Ok(table.with(handle, |_| Ok(())).unwrap_err().status)
            })
            .unwrap();
        assert_eq!(busy, IlonStatus::Busy);
    }

    #[test]
    fn after_a_panic_only_freeing_is_left() {
        let table = Table::new(1, "number");
        let handle = table.insert(0);
        let status = crate::status::guarded(|| table.with(handle, |_| panic!("amid a change")));
        assert_eq!(status, IlonStatus::Internal);
        let refused = table.with(handle, |_| Ok(())).unwrap_err();
        assert_eq!(refused.status, IlonStatus::Internal);
        table.remove(handle).unwrap();
    }
}
