//! Memory that is kept from one call to the next: lists that a call needs for a while.
//!
//! Whoever is asked again and again, a fitter or a detector, owns a `Memory` and lends it to its thread for
//! each call. A [`List`] that is made in such a call takes its room from there, and gives it back where it ends, so that a
//! call like the one before asks the allocator for nothing. Elsewhere a list is a `Vec`; so it is on the other threads of
//! a call, unless they lend a memory of their own. Nothing is kept beyond the owner of the memory. What a list is made
//! of has no part in any result.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::fmt;
use std::hash::{BuildHasherDefault, Hasher};
use std::num::NonZeroU64;
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[cfg(test)]
mod tests;

/// A list of more bytes than this is not kept: beside what is done with so many numbers it costs nothing to ask for it.
const LARGEST_KEPT: usize = 4 << 20;

/// Most lists of one type and about one size that are kept: a call has fewer at the same time.
const MOST_KEPT: usize = 512;

/// Sizes of lists, each twice the one before, of up to [`LARGEST_KEPT`] elements.
const SIZES: usize = LARGEST_KEPT.ilog2() as usize + 1;

thread_local! {
    /// What the call that this thread is in has lent to it.
    static LENT: RefCell<Option<Shelves>> = const { RefCell::new(None) };
}

/// Whether there is memory of so many bytes. It is asked for and given back at once, so that a call that could not have
/// it fails before it begins, and does not end the process in the middle.
pub(crate) fn is_there(bytes: usize) -> bool {
    let mut memory: Vec<u8> = Vec::new();
    let asked = memory.try_reserve_exact(bytes);
    // What nobody looks at need not be allocated.
    std::hint::black_box(&memory);
    asked.is_ok()
}

/// A list with an element for each view, of what borrows, so that no [`List`] can be made of it: a single one has its place
/// within.
#[derive(Debug, Clone)]
pub(crate) enum ByView<T> {
    /// That of a single view.
    One(T),
    /// Those of several views, or none.
    Several(Vec<T>),
}

impl<T> Deref for ByView<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::Several(several) => several,
        }
    }
}

impl<T> DerefMut for ByView<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::One(one) => std::slice::from_mut(one),
            Self::Several(several) => several,
        }
    }
}

impl<'a, T> IntoIterator for &'a ByView<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl<'a, T> IntoIterator for &'a mut ByView<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter_mut()
    }
}

impl<T> FromIterator<T> for ByView<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let mut items = items.into_iter();
        match (items.next(), items.next()) {
            (None, _) => Self::Several(Vec::new()),
            (Some(one), None) => Self::One(one),
            (Some(first), Some(second)) => Self::Several([first, second].into_iter().chain(items).collect()),
        }
    }
}

/// Empty lists of all types, a [`Shelf`] each, and the number that tells the lists of this memory from all others.
struct Shelves {
    of_types: HashMap<TypeId, Box<dyn Any + Send>, BuildHasherDefault<TypeHash>>,
    owner: Owner,
}

/// The hash of a type, which its number is already.
#[derive(Default)]
struct TypeHash(u64);

impl Hasher for TypeHash {
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.write_u64(u64::from(*byte));
        }
    }

    fn write_u64(&mut self, number: u64) {
        self.0 = self.0.rotate_left(8) ^ number;
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// The number of the shelves that a list belongs to; `None` for a list of none.
type Owner = Option<NonZeroU64>;

impl Shelves {
    fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(1);
        Self { of_types: HashMap::default(), owner: NonZeroU64::new(NEXT.fetch_add(1, Ordering::Relaxed)) }
    }

    /// The shelf of a type, a new one where there is none.
    fn of(&mut self, own: TypeId, new: fn() -> Box<dyn Any + Send>) -> &mut (dyn Any + Send) {
        &mut **self.of_types.entry(own).or_insert_with(new)
    }
}

/// Works on the shelf of a type in what is lent to this thread, if it is of this owner or any is right, and returns whose it is.
/// There are lists of so many types that the compiler is long about what each has a copy of: this has none.
fn with_shelf(
    own: TypeId,
    new: fn() -> Box<dyn Any + Send>,
    of: Owner,
    work: &mut dyn FnMut(&mut (dyn Any + Send)),
) -> Owner {
    // Where a thread ends there is nothing lent any more.
    let owner = LENT.try_with(|lent| {
        let mut lent = lent.borrow_mut();
        let shelves = lent.as_mut().filter(|shelves| of.is_none() || shelves.owner == of)?;
        work(shelves.of(own, new));
        shelves.owner
    });
    owner.ok().flatten()
}

/// Empty lists of one type: at k those with room for 2ᵏ elements and less than twice as many.
struct Shelf<T>(Vec<Vec<Vec<T>>>);

impl<T: Send + 'static> Shelf<T> {
    fn boxed() -> Box<dyn Any + Send> {
        let mut sizes = Vec::new();
        sizes.resize_with(SIZES, Vec::new);
        Box::new(Self(sizes))
    }

    /// Works on the shelf of this type, as [`with_shelf`] does.
    fn with(of: Owner, mut work: impl FnMut(&mut Self)) -> Owner {
        with_shelf(TypeId::of::<T>(), Self::boxed, of, &mut |shelf| {
            if let Some(shelf) = shelf.downcast_mut() {
                work(shelf);
            }
        })
    }

    /// A list with room for so many elements, and little more if possible: what is larger is for others. The one with most room
    /// where nobody knows how many.
    fn take(&mut self, count: Option<usize>) -> Option<Vec<T>> {
        let Some(count) = count else { return self.0.iter_mut().rev().find_map(Vec::pop) };
        let enough = count.checked_next_power_of_two()?.ilog2() as usize;
        self.0.get_mut(enough..)?.iter_mut().find_map(Vec::pop)
    }

    /// Keeps a list that has room.
    fn put(&mut self, list: Vec<T>) {
        let lists = &mut self.0[list.capacity().ilog2() as usize];
        if lists.len() < MOST_KEPT {
            lists.push(list);
        }
    }
}

/// Memory of calls that are made again and again: shelves for each of those that are made at the same time. A copy begins with
/// none.
#[derive(Default)]
pub(crate) struct Memory(Mutex<Vec<Shelves>>);

impl Memory {
    /// Does some work with this memory, or where a call about this one has lent its own, with that.
    pub fn lend<R>(&self, work: impl FnOnce() -> R) -> R {
        let lends = LENT.with_borrow_mut(|lent| {
            let lends = lent.is_none();
            if lends {
                // A call at the same time on another thread has its own.
                *lent = Some(self.not_lent().pop().unwrap_or_else(Shelves::new));
            }
            lends
        });
        // The memory comes back after a panic, too.
        let _loan = lends.then(|| Loan(self));
        work()
    }

    fn not_lent(&self) -> MutexGuard<'_, Vec<Shelves>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clone for Memory {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Memory {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("Memory")
    }
}

/// Does some work without the memory that a call has lent: what it makes has room of its own, and no more than it needs.
pub(crate) fn apart<R>(work: impl FnOnce() -> R) -> R {
    struct Back(Option<Shelves>);
    impl Drop for Back {
        fn drop(&mut self) {
            LENT.set(self.0.take());
        }
    }
    let _back = Back(LENT.take());
    work()
}

/// Memory that is lent.
struct Loan<'a>(&'a Memory);

impl Drop for Loan<'_> {
    fn drop(&mut self) {
        if let Some(shelves) = LENT.take() {
            self.0.not_lent().push(shelves);
        }
    }
}

/// A `Vec` whose room comes from the memory of the call that it is made in, if any, and goes back there with a call of the
/// same memory: were those of others kept, too, there would be more with each call.
///
/// It is read as a `Vec` is: `list.to_vec()` copies it into one.
pub struct List<T: Send + 'static>(Vec<T>, Owner);

impl<T: Send + 'static> List<T> {
    /// A list of nothing.
    #[must_use]
    pub fn new() -> Self {
        Self::lent(None)
    }

    /// A list of nothing that takes no room of the memory, and gives none.
    #[must_use]
    pub const fn apart() -> Self {
        Self(Vec::new(), None)
    }

    /// A list of nothing with room.
    #[must_use]
    pub fn with_capacity(capacity: usize) -> Self {
        let mut list = Self::lent(Some(capacity));
        if list.capacity() < capacity {
            // As much as is looked for the next time, where it is kept.
            let is_kept = list.1.is_some() && Self::is_kept(capacity);
            list.reserve_exact(if is_kept { capacity.next_power_of_two() } else { capacity });
        }
        list
    }

    /// Whether a list with room for so many is kept: all that are taken for as many elements can hold them.
    fn is_kept(capacity: usize) -> bool {
        let size = capacity.checked_next_power_of_two().unwrap_or(usize::MAX);
        size.saturating_mul(size_of::<T>()) <= LARGEST_KEPT
    }

    /// What the memory of the call has, if any.
    fn lent(count: Option<usize>) -> Self {
        let mut list = None;
        let owner = Shelf::with(None, |shelf| list = shelf.take(count));
        Self(list.unwrap_or_default(), owner)
    }

    /// So many times the same.
    #[must_use]
    pub fn filled(value: T, count: usize) -> Self
    where
        T: Clone,
    {
        let mut list = Self::with_capacity(count);
        list.resize(count, value);
        list
    }
}

impl<T: Send + 'static> Drop for List<T> {
    fn drop(&mut self) {
        if self.1.is_none() || self.0.capacity() * size_of::<T>() == 0 || !Self::is_kept(self.0.capacity()) {
            return;
        }
        let mut list = std::mem::take(&mut self.0);
        // Its elements may be lists.
        list.clear();
        Shelf::with(self.1, |shelf| shelf.put(std::mem::take(&mut list)));
    }
}

impl<T: Send + 'static> Default for List<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Send + 'static> Deref for List<T> {
    type Target = Vec<T>;

    fn deref(&self) -> &Vec<T> {
        &self.0
    }
}

impl<T: Send + 'static> DerefMut for List<T> {
    fn deref_mut(&mut self) -> &mut Vec<T> {
        &mut self.0
    }
}

impl<T: Clone + Send + 'static> From<&[T]> for List<T> {
    fn from(items: &[T]) -> Self {
        items.iter().cloned().collect()
    }
}

impl<T: Send + 'static, const N: usize> From<[T; N]> for List<T> {
    fn from(items: [T; N]) -> Self {
        items.into_iter().collect()
    }
}

impl<T: Send + 'static> FromIterator<T> for List<T> {
    fn from_iter<I: IntoIterator<Item = T>>(items: I) -> Self {
        let items = items.into_iter();
        let mut list = match items.size_hint() {
            // Of what goes through a filter all may come.
            (_, Some(most)) if Self::is_kept(most) => Self::with_capacity(most),
            _ => Self::new(),
        };
        list.extend(items);
        list
    }
}

/// The elements of a list, one by one.
pub struct Elements<T: Send + 'static>(List<T>);

impl<T: Send + 'static> Iterator for Elements<T> {
    type Item = T;

    fn next(&mut self) -> Option<T> {
        // They stand in the other order.
        self.0.pop()
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.0.len(), Some(self.0.len()))
    }
}

impl<T: Send + 'static> IntoIterator for List<T> {
    type Item = T;
    type IntoIter = Elements<T>;

    fn into_iter(mut self) -> Elements<T> {
        self.reverse();
        Elements(self)
    }
}

impl<'a, T: Send + 'static> IntoIterator for &'a List<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<'a, T: Send + 'static> IntoIterator for &'a mut List<T> {
    type Item = &'a mut T;
    type IntoIter = std::slice::IterMut<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.0.iter_mut()
    }
}

impl<T: Clone + Send + 'static> Clone for List<T> {
    fn clone(&self) -> Self {
        self.iter().cloned().collect()
    }
}

impl<T: Eq + Send + 'static> Eq for List<T> {}

impl<T: PartialEq + Send + 'static> PartialEq for List<T> {
    fn eq(&self, other: &Self) -> bool {
        self.0 == other.0
    }
}

impl<T: fmt::Debug + Send + 'static> fmt::Debug for List<T> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(formatter)
    }
}
