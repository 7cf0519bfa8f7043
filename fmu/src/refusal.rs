//! The reason why a call is refused.

/// The result of a refused call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// The call is wrong. It changed nothing, so the host can correct and repeat it.
    Error,
    /// The call requests something that is not available here.
    Discard,
    /// The block panicked; the instance is lost.
    Fatal,
}

/// The reason why a call is refused. It is one pointer wide so that it costs successful calls nothing.
#[derive(Debug)]
pub struct Refusal(Box<(Answer, String)>);

impl Refusal {
    /// A refusal with this result.
    #[cold]
    pub fn new(answer: Answer, reason: String) -> Refusal {
        Refusal(Box::new((answer, reason)))
    }

    /// The result of the call.
    pub fn answer(&self) -> Answer {
        self.0.0
    }

    /// The reason: the problem and the value, and the remedy if it is not obvious.
    pub fn reason(&self) -> &str {
        &self.0.1
    }
}

impl From<String> for Refusal {
    #[cold]
    fn from(reason: String) -> Refusal {
        Refusal::new(Answer::Error, reason)
    }
}

impl From<&str> for Refusal {
    #[cold]
    fn from(reason: &str) -> Refusal {
        Refusal::new(Answer::Error, reason.into())
    }
}
