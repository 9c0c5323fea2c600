"""What a backend promises, one sentence for each check of the kit.

The check of `names-are-full` is the method `test_names_are_full`, and so on.
"""

from rosbase.testing.promise import Promise

__all__ = ["PROMISES", "promise"]

_PAGE = "plugins/backend-contract"

_SENTENCES = {
    # Opening.
    "opens": "make_backend gives a Backend, under the name in its options",
    "leaves-the-executor-alone": (
        "executor, call_soon, spin_once and spin_until are those that Backend has made"
    ),
    "takes-a-clock": "stamps, timers and deadlines are those of the clock in its options",
    "lifecycle-nodes-are-exposed": (
        "lifecycle nodes can be built on it, more than one, and go through their transitions"
    ),
    "log-handler-raises-nothing": (
        "log_handler takes any record from any thread, also after close, and raises nothing"
    ),
    # Threads.
    "calls-come-from-any-thread": (
        "what any thread hands to call_soon is called on the thread that spins, in order"
    ),
    "callbacks-run-on-the-spinning-thread": (
        "every callback runs on the thread that spins, and only while it spins"
    ),
    "callbacks-may-use-the-backend": (
        "a callback may publish, create and destroy; what it publishes arrives"
    ),
    "messages-wake-the-spinner": "a spinner that waits is woken by a message",
    "errors-reach-the-spinner": (
        "what a callback raises is raised to whoever spins, who may go on spinning,"
        " and costs no other message"
    ),
    "publishing-is-for-any-thread": (
        "several threads may publish at once: nothing is lost, and what each sends stays in order"
    ),
    "publishing-waits-for-nobody": "publish returns at once although nobody handles messages",
    "destroying-is-for-any-thread": (
        "publishers, subscriptions and timers may be destroyed by any thread"
    ),
    # Topics.
    "every-subscription-hears": (
        "a message reaches every subscription of its topic, once, whether the topic is called"
        " `scan` or `/scan`"
    ),
    "messages-arrive-equal": (
        "messages of every class of rosbase.messages arrive equal to what was sent"
    ),
    "names-are-full": "`topic` is the full name: `/scan` for `scan`, `/<node>/scan` for `~/scan`",
    "wrong-names-are-errors": "what is no topic name is a BackendError of one line that shows it",
    "wrong-types-are-errors": (
        "a topic has one type: another one is a BackendError of one line that names the topic"
    ),
    "wrong-messages-are-errors": (
        "a message of another class is a TypeError of one line that names the topic,"
        " and nobody gets it"
    ),
    "samples-arrive-like-messages": (
        "what imu_sender sends arrives as the message would that has template, stamp and numbers"
    ),
    "delivers-in-process": (
        "where delivers_in_process is true, publish has queued the message itself, no copy,"
        " with this process's own subscriptions"
    ),
    "backends-hear-each-other": "backends of one world share their topics",
    # Quality of service.
    "depth-drops-the-oldest": (
        "as many messages as the depth says wait for the callback; older ones are dropped"
        " and counted"
    ),
    "keep-all-drops-none": "with KEEP_ALL every message waits for the callback",
    "handled-messages-are-not-kept": ("a message that has been handled takes no memory any more"),
    "late-subscriptions-get-what-was-kept": (
        "a TRANSIENT_LOCAL subscription that comes late gets the publisher's last messages,"
        " in order, before what is published later"
    ),
    "late-subscriptions-miss-none": (
        "of what is published while a TRANSIENT_LOCAL subscription comes, nothing is lost and"
        " nothing comes twice"
    ),
    "volatile-gets-only-the-new": "a VOLATILE subscription gets nothing from before it came",
    "kept-messages-end-with-the-publisher": "what a publisher keeps is gone when it is destroyed",
    "weak-offers-are-not-heard": (
        "a subscription gets nothing from a publisher that offers less than it asks for,"
        " and hears one that offers more"
    ),
    "weak-offers-are-warned-of": (
        "a warning names the topic on which a publisher offers less than a subscription asks for"
    ),
    "wrong-profiles-are-errors": (
        "what is neither a depth from 1 up nor a profile is a BackendError of one line that"
        " shows it"
    ),
    # Timers.
    "timers-keep-to-their-deadlines": (
        "a timer's deadlines are absolute: a call that is late does not put off the next one"
    ),
    "timers-keep-their-period": (
        "over many periods a timer is neither slower nor faster than its period"
    ),
    "missed-calls-are-skipped": "calls that a timer has missed are skipped, not caught up",
    "timers-wait-one-period": "the first call of a timer is one period after it was created",
    "cancelled-timers-rest": "a timer is not called back from cancel to reset, which tell of it",
    "reset-begins-a-new-period": "the next call after reset is one period from then",
    "destroyed-timers-stay-so": (
        "a destroyed timer is not called back, also if it destroyed itself or is reset"
    ),
    "timers-wake-the-spinner": "a timer that another thread creates wakes a spinner that waits",
    "wrong-periods-are-errors": "a period that is no positive, finite number is a ValueError",
    # Names.
    "wrong-node-names-are-errors": (
        "a node name that ROS refuses is a BackendError of one line that shows it, and nothing"
        " is opened"
    ),
    # Parameters.
    "parameters-keep-their-kind": "a declared parameter has its default, of the kind declared",
    "overrides-win": "an override wins over the default, as a value of the parameter's kind",
    "wrong-overrides-are-errors": (
        "an override that is no value of the parameter is a ParameterError of one line that"
        " names it, and the parameter stays undeclared"
    ),
    "declaring-twice-is-an-error": "a parameter declared twice is a ParameterError that names it",
    "setting-keeps-the-declared-kind": (
        "a parameter that is set has the new value, of the kind declared: 5 for a number is 5.0"
    ),
    "what-cannot-be-set-is-refused-whole": (
        "of several parameters none is set if one is undeclared, read-only or no value of its"
        " kind, and the reason is one line that names it"
    ),
    "a-callback-may-refuse-what-is-set": (
        "callbacks are asked before parameters are set, with the values as they will be, and"
        " what one refuses stays as it is"
    ),
    "undeclared-parameters-are-errors": (
        "a parameter that was not declared is a ParameterError that names it"
    ),
    # The end.
    "destroyed-subscriptions-are-silent": (
        "a destroyed subscription is not called back, also for what waited already"
    ),
    "ended-publishers-are-silent": (
        "publish and the senders made of a publisher send nothing, and raise nothing, once it has"
        " been destroyed or its backend closed"
    ),
    "destroying-twice-is-harmless": (
        "destroying what has ended, by destroying or by close, raises nothing"
    ),
    "last-words-arrive": "what was published arrives although its publisher is destroyed after it",
    "last-words-outlive-the-backend": (
        "what was published arrives although its backend is closed after it"
    ),
    "closing-twice-is-harmless": "close may be called again",
    "closing-is-bounded": "close returns within seconds, whatever waits to be handled",
    "closing-ends-threads": "the threads that a backend has started end with it",
    "closing-gives-descriptors-back": (
        "the descriptors that a backend has opened are closed with it"
    ),
    "closed-backends-call-nobody": (
        "after close nothing is called back, whatever was waiting or is reset"
    ),
    "closed-backends-refuse": (
        "creating a publisher, a subscription or a timer of a closed backend is a BackendError"
    ),
    "closing-leaves-others-alone": "closing a backend does nothing to others of its world",
}

PROMISES = {name: Promise(name, sentence, _PAGE) for name, sentence in _SENTENCES.items()}
"""Every promise by its name, in the order of the page."""

promise = PROMISES.__getitem__
"""The promise of that name."""
