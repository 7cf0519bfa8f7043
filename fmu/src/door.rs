//! The door through which every call of a host passes: it checks the state, catches panics, and logs why a call is
//! refused. The code inside may panic or refuse; the code outside, the C functions of a version of the
//! standard, only turns pointers into references.

use crate::component::Component;
use crate::cyclic::Cyclic;
use crate::log::Category;
use crate::refusal::{Answer, Refusal};
use crate::state::Function;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::thread;

/// The host as the receiver of log messages.
pub trait Host {
    /// Logs a message about a function whose result is `answer`.
    fn tell(&self, function: &Function, answer: Result<(), Answer>, category: &Category, message: &str);

    /// Logs why a call was refused.
    fn log(&self, function: &Function, refusal: &Refusal) {
        self.tell(function, Err(refusal.answer()), Category::for_answer(refusal.answer()), refusal.reason());
    }
}

/// A component and its host.
pub struct Door<B: Cyclic, H> {
    component: Component<B>,
    host: H,
}

impl<B: Cyclic, H: Host> Door<B, H> {
    /// A door to the component that `component` creates. If that refuses or panics, the reason is logged regardless of
    /// the host's log settings: without an instance, there is no other way to report the error.
    pub fn new(
        host: H,
        function: &Function,
        component: impl FnOnce() -> Result<Component<B>, Refusal>,
    ) -> Option<Door<B, H>> {
        match catch_unwind(AssertUnwindSafe(component)).unwrap_or_else(|panic| Err(panic_refusal(panic))) {
            Ok(component) => Some(Door { component, host }),
            Err(refusal) => {
                host.log(function, &refusal);
                None
            }
        }
    }

    /// Runs a function on the component if its state allows it, and catches panics. All functions on a component are
    /// run this way.
    #[inline(always)]
    pub fn enter(
        &mut self,
        function: &'static Function,
        body: impl FnOnce(&mut Component<B>) -> Result<(), Refusal>,
    ) -> Result<(), Answer> {
        let done = catch_unwind(AssertUnwindSafe(|| {
            self.component.instance.may(function)?;
            body(&mut self.component)
        }));
        match done {
            Ok(Ok(())) if self.component.advice.is_empty() => Ok(()),
            done => self.tell(function, done),
        }
    }

    /// Drops the component, even if dropping a part of it panics.
    pub fn close(mut self: Box<Self>) {
        // One by one: a panic while another unwinds would end the process.
        self.component.take_saved().into_iter().for_each(discard);
        discard(self);
    }

    /// Logs how a call ended and returns its result.
    #[cold]
    #[inline(never)]
    fn tell(&mut self, function: &Function, done: thread::Result<Result<(), Refusal>>) -> Result<(), Answer> {
        match done {
            Ok(Ok(())) => {
                for advice in std::mem::take(&mut self.component.advice) {
                    self.host.tell(function, Ok(()), &Category::ADVICE, &advice);
                }
                Ok(())
            }
            Ok(Err(refusal)) => Err(self.refuse(function, &refusal)),
            Err(panic) => {
                self.component.instance.lock();
                Err(self.refuse(function, &panic_refusal(panic)))
            }
        }
    }

    /// Logs a refusal and returns its result.
    fn refuse(&self, function: &Function, refusal: &Refusal) -> Answer {
        if self.component.logged.contains(Category::for_answer(refusal.answer())) {
            self.host.log(function, refusal);
        }
        refusal.answer()
    }
}

#[cold]
fn panic_refusal(panic: Box<dyn Any + Send>) -> Refusal {
    let text = panic.downcast_ref::<&str>().copied().or(panic.downcast_ref::<String>().map(String::as_str));
    let reason =
        format!("panic in the block: {}; the instance is locked and can only be freed", text.unwrap_or("no message"));
    discard(panic);
    Refusal::new(Answer::Fatal, reason)
}

/// Drops a value from a block, catching any panic.
fn discard<T>(value: T) {
    if let Err(panic) = catch_unwind(AssertUnwindSafe(|| drop(value)))
        && let Err(another) = catch_unwind(AssertUnwindSafe(|| drop(panic)))
    {
        // Dropping the payload panicked, too. The second payload is leaked: dropping it might panic again.
        std::mem::forget(another);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_in_dropping_what_a_block_made_ends_there() {
        struct Loud;
        impl Drop for Loud {
            fn drop(&mut self) {
                panic!("dropped");
            }
        }
        discard(Loud);
    }
}
