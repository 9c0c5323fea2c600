"""Known texts of devices and related programs: boot messages, crashes, modems, servers."""

import re

from rosbase.imu.diagnosis.cause import Cause

__all__ = ["diagnose_saying"]

# What a text is, and how such texts begin, or what they hold. In lower case.
_FAULTS: dict[str, tuple[str, ...]] = {
    "an ESP32 resets because its voltage drops; is the supply or the cable too weak?": (
        r"brownout detector",
    ),
    "the firmware crashes": (
        r"guru meditation",
        r"^backtrace:",
        r"abort\(\) was called",
        r"kernel panic",
        r"hard ?fault",
        r"^stack overflow",
    ),
    "the firmware hangs, and its watchdog resets it": (
        r"task watchdog got triggered",
        r"wdt reset",
    ),
    "a program in Python on the device raises": (r"traceback \(most recent call last\)",),
    "AT commands or their answers, as of a modem": (
        r"^at(?:[+&]\w.*|[ezi]\d?)?$",
        r"^\+cm[es] error",
        r"^\+[a-z]{3,8}: ",
        r"^no carrier$",
        r"^ring$",
    ),
    "a page in HTML, as of a server that refuses": (r"^<!doctype html", r"^<html", r"^<head>"),
    "HTTP, as of a web server": (
        r"^http/\d",
        r"^(?:get|post|put) /\S* http/\d",
    ),
    "XML; the sender must encode it as JSON": (r"^<\?xml", r"^<\w+(?: [^<>]*)?>.*</\w+>$"),
    "YAML; the sender must encode it as JSON": (r"^---$", r"^[a-z_]\w*:$"),
}
_AT_START: dict[str, tuple[str, ...]] = {
    "an ESP32 or ESP8266 starts": (
        r"^ets [a-z]{3} ",
        r"^rst:0x",
        r"^configsip:",
        r"^clk_drv:",
        r"^mode:\w+, clock div",
        r"^load:0x",
        r"^entry 0x",
        r"^boot:",
        r"^esp-rom:",
        r"^build:[a-z]{3} ",
        r"^saved pc:0x",
        r"^spiwp:",
    ),
    "a line of the log of ESP-IDF": (r"^[ewidv] \(\d+\) [\w .-]+:",),
    "a line of the log of the Arduino core for ESP32": (
        r"^\[ *\d+\]\[[ewidv]\]",
        r"^\[[ewidv]\]\[",
    ),
    "a line of the log of Zephyr": (
        r"^\[\d\d:\d\d:\d\d\.\d{3},\d{3}\] <",
        r"^\*\*\* booting zephyr",
    ),
    "MicroPython or CircuitPython starts, or waits at its prompt": (
        r"^micropython v",
        r"^mpy: ",
        r"^>>> ",
        r"^adafruit circuitpython",
        r"code\.py output",
    ),
    "a console of Linux": (r"^\[ *\d+\.\d{6}\] ", r"^u-boot ", r"login: *$", r"^starting kernel"),
    "a word at the start, or an answer to a command": (r"^ok$", r"^ready$"),
}


def _compiled(sayings: dict[str, tuple[str, ...]]) -> dict[str, re.Pattern[str]]:
    return {what: re.compile("|".join(patterns)) for what, patterns in sayings.items()}


_COMPILED = ((_compiled(_FAULTS), False), (_compiled(_AT_START), True))


def diagnose_saying(text: str) -> Cause | None:
    """Return the kind of a text, if devices or programs around them are known to print it."""
    text = text.casefold().strip()
    for sayings, is_harmless in _COMPILED:
        for what, pattern in sayings.items():
            if pattern.search(text):
                return Cause(what, is_harmless)
    return None
