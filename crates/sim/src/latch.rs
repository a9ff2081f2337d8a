//! What keeps a word for a number of clocks.

/// A chain of registers: what goes in comes out `clocks` later. A stage that reads gets only [`output`](Delay::output),
/// a stage that writes only [`shift`](Delay::shift); `None` is a bubble.
#[derive(Clone, Debug)]
pub struct Delay<T> {
    words: Box<[Option<T>]>,
    next: usize,
}

impl<T: Copy> Delay<T> {
    /// A chain of `clocks` registers, at least one.
    pub fn new(clocks: u32) -> Delay<T> {
        Delay {
            words: vec![None; clocks.max(1) as usize].into(),
            next: 0,
        }
    }

    /// The word that leaves in this clock.
    #[inline(always)]
    pub fn output(&self) -> Option<T> {
        self.words[self.next]
    }

    /// The clock edge: everything moves on by one register, `input` enters the first.
    #[inline(always)]
    pub fn shift(&mut self, input: Option<T>) {
        let word = &mut self.words[self.next];
        // Bubbles behind bubbles need no write.
        if word.is_some() || input.is_some() {
            *word = input;
        }
        self.next += 1;
        if self.next == self.words.len() {
            self.next = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_come_out_after_their_clocks_in_their_order() {
        let mut delay = Delay::new(3);
        let input = [Some(1), None, Some(2), Some(3), None, None, None, None];
        let mut output = Vec::new();
        for word in input {
            output.push(delay.output());
            delay.shift(word);
        }
        assert_eq!(
            output,
            [None, None, None, Some(1), None, Some(2), Some(3), None]
        );
    }
}
