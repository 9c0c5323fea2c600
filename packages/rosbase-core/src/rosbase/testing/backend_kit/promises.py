"""Promises of a backend, one sentence for each check of the kit.

The check of `names-are-full` is the method `test_names_are_full`, and so on.
"""

from rosbase.testing.promise import Promise

__all__ = ["PROMISES", "promise"]

_PAGE = "plugins/backend-contract"

_SENTENCES = {
    # Opening.
    "opens": "make_backend returns a Backend with the name in its options",
    "leaves-the-executor-alone": (
        "executor, call_soon, spin_once and spin_until are those of the base class Backend"
    ),
    "takes-a-clock": "Stamps, timers and deadlines use the clock in its options",
    "lifecycle-nodes-are-exposed": (
        "Several lifecycle nodes can be built on it and go through their transitions"
    ),
    "log-handler-raises-nothing": (
        "log_handler takes any record from any thread, also after close, and raises nothing"
    ),
    # Threads.
    "calls-come-from-any-thread": (
        "Any thread may use call_soon; the calls run on the thread that spins, in order"
    ),
    "callbacks-run-on-the-spinning-thread": (
        "Every callback runs on the thread that spins, and only while it spins"
    ),
    "callbacks-may-use-the-backend": (
        "A callback may publish, create and destroy; the messages it publishes arrive"
    ),
    "messages-wake-the-spinner": "A message wakes a spinner that waits",
    "errors-reach-the-spinner": (
        "An exception in a callback is raised to the caller that spins, who may spin again; no"
        " other message is lost"
    ),
    "publishing-is-for-any-thread": (
        "Several threads may publish at once: nothing is lost, and the messages of each stay in"
        " order"
    ),
    "publishing-waits-for-nobody": "publish returns at once although nobody handles messages",
    "destroying-is-for-any-thread": "Any thread may destroy publishers, subscriptions and timers",
    # Topics.
    "every-subscription-hears": (
        "A message reaches every subscription of its topic, once, with the topic written as"
        " `scan` or `/scan`"
    ),
    "messages-arrive-equal": (
        "Messages of every class of rosbase.messages arrive equal to the ones sent"
    ),
    "names-are-full": "`topic` is the full name: `/scan` for `scan`, `/<node>/scan` for `~/scan`",
    "wrong-names-are-errors": "An invalid topic name is a BackendError of one line that shows it",
    "wrong-types-are-errors": (
        "A topic has one type: another one is a BackendError of one line that names the topic"
    ),
    "wrong-messages-are-errors": (
        "A message of another class, also from a prepared sender, is a TypeError of one line that"
        " names the topic, and nobody receives it"
    ),
    "samples-arrive-like-messages": (
        "A prepared sender sends the message of its template and values"
    ),
    "delivers-in-process": (
        "If delivers_in_process is True, publish has queued the message itself, no copy, with"
        " this process's own subscriptions"
    ),
    "backends-hear-each-other": "Backends of one world share their topics",
    # Taps and the graph.
    "taps-hear-what-is-published": (
        "A tap hears each message of its topic once, in order: from publishers that were there and"
        " from later ones, from senders, and whether there is a subscription or not"
    ),
    "taps-hear-what-arrives": (
        "A tap hears a message from outside once, if a subscription of its backend gets it,"
        " however many subscriptions there are"
    ),
    "taps-hear-equal-messages": (
        "A tap hears the message that was published, or its bytes in the format of its class"
    ),
    "closed-taps-are-silent": (
        "A closed tap hears nothing, the others hear on, and closing twice or after the backend is"
        " harmless"
    ),
    "failing-taps-harm-nobody": (
        "If the function of a tap raises, the message reaches everybody else, publish raises"
        " nothing, and that tap hears nothing more"
    ),
    "wrong-taps-are-errors": (
        "A tap of an invalid topic name, or of a closed backend, is a BackendError of one line"
    ),
    "new-ends-are-told": (
        "new_ends tells of each publisher and subscription before create_publisher and"
        " create_subscription return, so a tap that is added then misses no message"
    ),
    "kept-messages-are-told": (
        "kept_messages has what the TRANSIENT_LOCAL publishers of a topic keep, in order, and"
        " nothing of publishers that have ended"
    ),
    "graphs-tell-the-ends": (
        "The graph has each publisher, subscription, service and client while it exists, with its"
        " node, full name, type and quality of service"
    ),
    # Quality of service.
    "depth-drops-the-oldest": (
        "At most `depth` messages wait for the callback; older ones are dropped and counted"
    ),
    "keep-all-drops-none": "With KEEP_ALL, every message waits for the callback",
    "handled-messages-are-not-kept": "A handled message takes no memory any more",
    "late-subscriptions-get-what-was-kept": (
        "A late TRANSIENT_LOCAL subscription gets the publisher's last messages, in order, before"
        " later ones"
    ),
    "late-subscriptions-miss-none": (
        "Messages published while a TRANSIENT_LOCAL subscription is created arrive once: none is"
        " lost, none comes twice"
    ),
    "volatile-gets-only-the-new": (
        "A VOLATILE subscription gets no message from before its creation"
    ),
    "kept-messages-end-with-the-publisher": (
        "The messages that a publisher keeps are gone when it is destroyed"
    ),
    "weak-offers-are-not-heard": (
        "A subscription gets nothing from a publisher that offers less than it requests, and"
        " hears one that offers more"
    ),
    "weak-offers-are-warned-of": (
        "A warning names the topic on which a publisher offers less than a subscription requests"
    ),
    "wrong-profiles-are-errors": (
        "A value that is neither a depth from 1 up nor a profile is a BackendError of one line"
        " that shows it"
    ),
    # Timers.
    "timers-keep-to-their-deadlines": (
        "The deadlines of a timer are absolute: a late call does not delay the next one"
    ),
    "timers-keep-their-period": (
        "Over many periods, a timer is neither slower nor faster than its period"
    ),
    "missed-calls-are-skipped": "Missed calls of a timer are skipped, not made up for",
    "timers-wait-one-period": "The first call of a timer is one period after its creation",
    "cancelled-timers-rest": (
        "A timer makes no calls from cancel to reset, and is_canceled shows it"
    ),
    "reset-begins-a-new-period": "The next call after reset is one period from then",
    "destroyed-timers-stay-so": (
        "A destroyed timer makes no calls, also if it destroyed itself or is reset"
    ),
    "timers-wake-the-spinner": "A timer that another thread creates wakes a spinner that waits",
    "timers-tell-their-time": (
        "timer_now_ns is the time of the timers, for any thread: from call to call of a timer, it"
        " advances by one period, whatever happens to the date"
    ),
    "wrong-periods-are-errors": "A period that is not a positive, finite number is a ValueError",
    # Names.
    "wrong-node-names-are-errors": (
        "A node name that ROS refuses is a BackendError of one line that shows it, and nothing is"
        " opened"
    ),
    # Parameters.
    "parameters-keep-their-kind": "A declared parameter has its default, of the declared kind",
    "overrides-win": "An override replaces the default, as a value of the parameter's kind",
    "wrong-overrides-are-errors": (
        "An invalid override is a ParameterError of one line that names it, and the parameter"
        " stays undeclared"
    ),
    "declaring-twice-is-an-error": "Declaring a parameter twice is a ParameterError that names it",
    "setting-keeps-the-declared-kind": (
        "A parameter that is set has the new value, of the declared kind: 5 for a number is 5.0"
    ),
    "what-cannot-be-set-is-refused-whole": (
        "If one of several parameters is undeclared, read-only or invalid, none is set, and the"
        " reason is one line that names it"
    ),
    "a-callback-may-refuse-what-is-set": (
        "Callbacks are asked before parameters are set, with the future values; a refused"
        " parameter keeps its value"
    ),
    "callbacks-hear-what-was-set": (
        "After parameters were set, callbacks are called with them, on the thread that spins;"
        " a refused parameter causes no call"
    ),
    "nodes-have-their-own-parameters": (
        "Nodes of one backend have their own parameters; `front.rate` sets the one of a node,"
        " `rate` those of all; callbacks are asked about their own node only"
    ),
    "parameters-are-listed": (
        "A node lists the parameters that it has declared, in order, without those of lifecycle"
        " nodes, and describes each as declared"
    ),
    "undeclared-parameters-are-errors": "An undeclared parameter is a ParameterError that names it",
    # Services.
    "services-answer": (
        "Every request reaches the service of its name, written as `open` or `/open`, and its"
        " answer the caller"
    ),
    "service-names-are-full": (
        "`service_name` is the full name: `/open` for `open`, `/<node>/open` for `~/open`"
    ),
    "wrong-service-names-are-errors": (
        "An invalid name of a service is a BackendError of one line that shows it"
    ),
    "wrong-service-types-are-errors": (
        "A type without the classes Request and Response is a BackendError of one line that names"
        " the service"
    ),
    "wrong-requests-are-errors": (
        "A request of another class is a TypeError of one line that names the service, and nobody"
        " receives it"
    ),
    "any-thread-may-call": (
        "Several threads may call at once while another one spins: each gets its own answers"
    ),
    "callbacks-of-services-run-on-the-spinning-thread": (
        "The callbacks of services, and of futures, run on the thread that spins, and only while"
        " it spins or waits for an answer"
    ),
    "waiting-calls-let-services-run": (
        "A callback may call a service of its own backend, also the callback of a service"
    ),
    "waiting-calls-let-nothing-else-run": (
        "While the thread that spins waits for an answer, no message, timer or other call is"
        " handled"
    ),
    "two-may-call-each-other": (
        "Two that call each other at the same time, each on the thread that spins, get answers"
    ),
    "calls-are-limited-in-depth": (
        "16 calls may wait, each in a callback that the one before runs; one more is a"
        " ServiceDepthError"
    ),
    "absent-services-are-errors": (
        "A call of an absent service is a ServiceTimeoutError at its timeout, and"
        " wait_for_service returns False"
    ),
    "calls-wait-for-their-service": (
        "A call whose service comes within the timeout gets its answer"
    ),
    "late-answers-are-dropped-and-counted": (
        "A call whose answer comes after its timeout is a ServiceTimeoutError, also if its own"
        " thread answers, and the answer is dropped and counted"
    ),
    "cancelled-calls-stay-so": "A cancelled call has no result, also if its answer still comes",
    "failing-services-are-errors": (
        "If the callback of a service raises, its caller gets a ServiceError within the timeout,"
        " and the service goes on"
    ),
    "services-that-go-away-are-errors": (
        "If a service is destroyed before it answers, its caller gets a ServiceError within the"
        " timeout"
    ),
    "inner-calls-keep-to-the-time-of-outer-ones": (
        "A call in a callback that a waiting call runs does not last longer than that one may"
    ),
    "stops-end-calls": (
        "A request to stop ends a call that waits on the thread that spins with a"
        " ServiceStoppedError"
    ),
    "destroyed-clients-end-their-calls": (
        "The calls of a destroyed client fail with a ServiceError, and so do new ones; no service"
        " is ready for it"
    ),
    "closed-backends-end-services": (
        "After close, calls fail, services answer nothing, destroying is harmless, and creating is"
        " a BackendError"
    ),
    # The end.
    "destroyed-subscriptions-are-silent": (
        "A destroyed subscription makes no calls, also for messages that already waited"
    ),
    "ended-publishers-are-silent": (
        "After a publisher is destroyed or its backend closed, publish and its senders send"
        " nothing and raise nothing"
    ),
    "destroying-twice-is-harmless": (
        "Destroying an object again, after destroy or close, raises nothing"
    ),
    "last-words-arrive": (
        "A published message arrives although its publisher is destroyed afterwards"
    ),
    "last-words-outlive-the-backend": (
        "A published message arrives although its backend is closed afterwards"
    ),
    "closing-twice-is-harmless": "close may be called again",
    "closing-is-bounded": "close returns within seconds, however many messages wait",
    "closing-ends-threads": "The threads that a backend has started end with it",
    "closing-gives-descriptors-back": (
        "The descriptors that a backend has opened are closed with it"
    ),
    "closed-backends-call-nobody": (
        "After close there are no callbacks, whatever was waiting or is reset"
    ),
    "closed-backends-refuse": (
        "Creating a publisher, a subscription or a timer of a closed backend is a BackendError"
    ),
    "closing-leaves-others-alone": "Closing a backend does not affect others of its world",
}

PROMISES = {name: Promise(name, sentence, _PAGE) for name, sentence in _SENTENCES.items()}
"""Every promise by its name, in the order of the page."""

promise = PROMISES.__getitem__
"""Function that returns the promise of a name."""
