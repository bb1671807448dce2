use super::*;
use std::sync::Barrier;

/// How many lists of a type a memory keeps.
fn kept<T: Send + 'static>(memory: &Memory) -> usize {
    let mut all = memory.not_lent();
    let shelves = all.iter_mut().map(|shelves| shelves.of(TypeId::of::<T>(), Shelf::<T>::boxed));
    shelves.flat_map(|shelf| &shelf.downcast_ref::<Shelf<T>>().unwrap().0).map(Vec::len).sum()
}

#[test]
fn a_list_takes_its_room_from_the_memory_that_is_lent_and_gives_it_back_empty() {
    let memory = Memory::default();
    let room = memory.lend(|| {
        let list: List<f64> = (0..100).map(f64::from).collect();
        list.as_ptr()
    });
    assert_eq!(kept::<f64>(&memory), 1);
    memory.lend(|| {
        let again = List::filled(1.0, 100);
        assert_eq!((again.as_ptr(), again.len()), (room, 100));
        // Of another type, and a second one.
        let others = (List::filled(1_u64, 3), again.clone());
        assert!(others.1.as_ptr() != room && *others.1 == *again);
    });
    assert_eq!((kept::<f64>(&memory), kept::<u64>(&memory)), (2, 1));
    assert_eq!(kept::<f64>(&memory.clone()), 0);
}

#[test]
fn a_list_takes_the_room_of_its_size_or_the_largest_where_it_may_grow() {
    let memory = Memory::default();
    memory.lend(|| {
        let lists = [10, 1000, 100].map(|count| List::filled(0_u8, count));
        let rooms = lists.each_ref().map(|list| list.as_ptr());
        drop(lists);
        let room = |list: List<u8>| list.as_ptr();
        assert_eq!(room(List::filled(1, 70)), rooms[2]);
        assert_eq!(room((0..9).collect()), rooms[0]);
        assert_eq!(room(List::filled(1, 200)), rooms[1]);
        assert!(!rooms.contains(&room(List::filled(1, 2000))));
        // What may be left out by a filter, and what may grow.
        assert_eq!(room((0..250).chain(0..250).chain(0..250).filter(|k| k % 2 == 0).collect()), rooms[1]);
        assert!(!rooms.contains(&room(List::new())));
    });
}

#[test]
fn a_list_is_a_vec_where_nothing_is_lent() {
    let memory = Memory::default();
    let outlives = memory.lend(|| List::filled(2.0, 10));
    assert_eq!(*outlives, [2.0; 10]);
    drop(outlives);
    assert_eq!(kept::<f64>(&memory), 0);
}

#[test]
fn a_call_within_another_has_the_memory_of_that() {
    let (outer, inner) = (Memory::default(), Memory::default());
    outer.lend(|| inner.lend(|| drop(List::filled(0.0, 10))));
    assert_eq!((kept::<f64>(&outer), kept::<f64>(&inner)), (1, 0));
}

#[test]
fn calls_at_the_same_time_have_shelves_of_their_own() {
    let (memory, both) = (Memory::default(), Barrier::new(2));
    let call = || {
        memory.lend(|| {
            both.wait();
            drop(List::filled(0.0, 10));
            both.wait();
        });
    };
    for _ in 0..3 {
        std::thread::scope(|scope| {
            scope.spawn(call);
            call();
        });
        let shelves = memory.not_lent().len();
        assert_eq!((shelves, kept::<f64>(&memory)), (2, 2));
    }
}

#[test]
fn memory_comes_back_after_a_panic() {
    let memory = Memory::default();
    let work = || {
        memory.lend(|| {
            let _list = List::filled(0.0, 10);
            std::panic::resume_unwind(Box::new(()));
        });
    };
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(work)).is_err());
    assert_eq!(kept::<f64>(&memory), 1);
    assert!(LENT.with_borrow(Option::is_none));
}

#[test]
fn a_list_goes_back_to_the_memory_that_it_came_from_alone() {
    let (memory, other) = (Memory::default(), Memory::default());
    let list = || List::filled(0.0, 10);
    let (own, foreign, of_none) = (memory.lend(list), other.lend(list), list());
    memory.lend(|| drop((own, foreign, of_none)));
    assert_eq!((kept::<f64>(&memory), kept::<f64>(&other)), (1, 0));
    // One that takes no room gives none, either.
    memory.lend(|| {
        let mut list = List::apart();
        list.push(1.0);
        let of_none = apart(|| List::filled(0.0, 10));
        assert_eq!(of_none.capacity(), 10);
    });
    assert_eq!(kept::<f64>(&memory), 1);
}

#[test]
fn a_list_that_is_kept_is_found_again_whatever_the_size_of_its_elements() {
    let memory = Memory::default();
    for count in [100, 200_000, 262_144, 262_145, 300_000, 349_525, 349_526] {
        for _ in 0..3 {
            memory.lend(|| drop(List::filled([0_f32; 3], count)));
        }
        assert_eq!(kept::<[f32; 3]>(&memory), 1 + usize::from(count > 100), "{count}");
    }
}

#[test]
fn neither_large_lists_nor_very_many_are_kept() {
    let memory = Memory::default();
    memory.lend(|| {
        drop(List::filled(0_u8, LARGEST_KEPT + 1));
        drop((0..2 * MOST_KEPT).map(|_| List::filled(0_u8, 1)).collect::<Vec<_>>());
    });
    assert_eq!(kept::<u8>(&memory), MOST_KEPT);
}
