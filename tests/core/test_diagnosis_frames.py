"""What a frame is that is no JSON: the cause is told from the bytes, and noise stays noise."""

import base64
import bz2
import gzip
import json
import lzma
import struct
import time
import zlib
from random import Random

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rosbase.imu.diagnosis.cause import Cause
from rosbase.imu.diagnosis.frame import diagnose_frame
from support.packing import cbor, message_pack, protobuf
from support.samples import GOOD, GOOD_FRAME
from support.strategies import frames

pytestmark = pytest.mark.once

LINE = b'{"accel_x":0,"accel_y":0.5,"accel_z":9.81,"gyro_x":0,"gyro_y":0,"gyro_z":0.1}'
TEXT = LINE.decode()
# Three packets of the protocols that IMUs speak most, as their manuals have them.
WIT = bytes([0x55, 0x51, 0, 1, 0, 2, 0, 8, 0, 9])
UBX = b"\xb5\x62\x01\x07\x5c\x00" + bytes(94)
MAVLINK = b"\xfe\x09\x4e\x01\x01\x00\x00\x00\x00\x00\x02\x03\x51\x04\x03\x1c\x7f"


def remaining(length: int) -> bytes:
    return bytes([length % 128 | 128, length // 128]) if length > 127 else bytes([length])


def publish(topic: bytes, payload: bytes) -> bytes:
    body = struct.pack(">H", len(topic)) + topic + payload
    return b"\x30" + remaining(len(body)) + body


FRAMES: dict[str, tuple[bytes, str]] = {
    # The inputs of the field, and their siblings.
    "behind a terminal's time": (b"12:00:01.250 -> " + LINE, "JSON behind '12:00:01.250 -> '"),
    "gzip": (gzip.compress(LINE, mtime=0), "compressed with gzip"),
    # Something around it.
    "behind the log of ESP-IDF": (b"I (3245) imu: " + LINE, "not with ESP_LOG"),
    "behind its colour too": (b"\x1b[0;32mI (3245) imu: " + LINE + b"\x1b[0m", "ESP_LOG"),
    "behind a topic": (b"sensors/imu " + LINE, "JSON behind 'sensors/imu ', a name"),
    "behind a name": (b"IMU: " + LINE, "JSON behind 'IMU: ', a name"),
    "behind a form's field": (b"data=" + LINE, "JSON behind 'data=', a name"),
    "behind a prompt": (b">>> " + LINE, "JSON behind '>>> '"),
    "behind a date of a log": (b"[12:00:01.250] " + LINE, "a timestamp of whoever logs it"),
    "before a tail": (LINE + b" ok", "more behind the JSON, 'ok'"),
    "before a checksum": (LINE + b"*5A", "set the parameter checksum"),
    "before a long checksum": (LINE + b" * cbf43926", "set the parameter checksum"),
    "two in a row": (LINE + LINE, "several JSON values in one frame"),
    "two with a comma": (LINE + b", " + LINE, "several JSON values in one frame"),
    "two in a message": (LINE + b"\r\n" + LINE, "several JSON values in one frame"),
    "one runs into the next": (b'{"accel_x":0,"acc' + LINE, "one line runs into the next"),
    "a missed beginning": (b'0.1,"z":9.8}}', "the end of a line whose beginning was missed"),
    "missed up to a key": (
        b'ty":{"x":0.5,"y":0.1}}',
        "the end of a line whose beginning was missed",
    ),
    # JSON in a text.
    "encoded twice": (json.dumps(TEXT).encode(), "it is encoded twice"),
    "escaped": (LINE.replace(b'"', b'\\"'), "escaped with backslashes"),
    "base64": (base64.b64encode(LINE), "JSON in base64"),
    "hexadecimal": (LINE.hex().encode(), "JSON in hexadecimal digits"),
    "hexadecimal of bytes": (b"55 51 00 0a ff 02 00 08", "bytes in hexadecimal digits"),
    # The habits of other languages.
    "decimal commas": (b'{"ax":0,12,"ay":-9,81}', "numbers with a decimal comma"),
    "single quotes": (b"{'ax': 0.1, 'ok': True, 'n': None}", "as Python prints it"),
    "None": (b'{"ax": None, "ay": 0.2}', "as Python prints it"),
    "nan": (b'{"ax":nan,"ay":-nan(ind),"az":9.81}', "nan or inf, as C prints them"),
    "inf": (b'{"acc":[inf, 0.0,-inf]}', "nan or inf, as C prints them"),
    "nan of Windows": (b'{"ax":1.#QNAN,"ay":0.5}', "nan or inf, as C prints them"),
    "nan and commas": (b'{"ax":nan,"ay":0,5}', "point; nan or inf, as C prints them"),
    "keys without quotes": (b"{ax:0.1, ay:0.2}", "keys without quotes"),
    "curly quotes": ("{\u201cacc\u201d:[0,0,9.8]}".encode(), "curly quotes"),
    "curly quotes around an object": (
        '{\u201eacc\u201c:{"x":0.1}}'.encode(),
        "curly quotes, as a word processor makes them",
    ),
    "single curly quotes": ("{\u2018ax\u2019:0.1,\u2018ay\u2019:0.2}".encode(), "curly quotes"),
    "equals signs in JSON": (b'{"acc"=[0,0,9.8]}', "an equals sign where JSON has a colon"),
    "equals signs inside": (b'{"a":{"x" = 0.1,"y" = -2},"b":5}', "an equals sign"),
    "one runs into the next after lists": (
        b'{"acc":[0,0,9.8],"gyr":[0,0,1],"t{"acc":[0,0,9.8],"gyr":[0,0,1]}',
        "one line runs into the next",
    ),
    "a last comma": (b'{"ax":0.1,"ay":0.2,}', "a comma before a closing bracket"),
    "a plus": (b'{"ax":+0.1,"ay":-0.2}', "numbers that JSON does not know"),
    "a point without a digit": (b'{"ax":.1,"ay":2.}', "numbers that JSON does not know"),
    "leading zeros": (b'{"ax":007}', "numbers that JSON does not know"),
    "newlib-nano": (b'{"ax":,"ay":,"az":}', "does its printf know %f?"),
    "printf of AVR": (b'{"ax":?,"ay":?}', "does its printf know %f?"),
    "formats": (b'{"ax":%f,"ay":%.2f}', "a format such as %f"),
    "a comma is missing": (b'{"ax":0.1 "ay":0.2}', "a comma is missing"),
    "cut off": (LINE[:31], "cut off after 31 bytes"),
    "cut off by a buffer": (GOOD_FRAME[:128], "is a buffer of 128 bytes too small?"),
    "cut off in a text": (b'{"name":"imu of the', "cut off after 19 bytes"),
    # Numbers without JSON.
    "CSV": (b"0.1,0.2,9.8,-0.01,0.0,0.5", "6 numbers in a row (CSV)"),
    "tabs": (b"0.1\t0.2\t9.8", "3 numbers in a row (CSV)"),
    "a plotter": (b"ax:0.10,ay:-0.20,az:9.81", "numbers with labels"),
    "equals signs": (b"ax=0.1 ay=-0.2 az=9.8", "numbers with labels"),
    "razor": (b"#YPR=12.3,4.5,6.7", "numbers behind the tag 'YPR'"),
    "NMEA": (b"$GPGGA,123519,4807.038,N,01131.000,E,1,08*47", "as of a GPS receiver"),
    "VectorNav": (b"$VNYMR,+006.271,+000.031,-002.000*65", "VectorNav"),
    "NMEA of a compass": (b"$HCHDM,238.5,M*2D", "HCHDM, a sentence of NMEA 0183"),
    # What devices and those around them say.
    "ROM of an ESP32": (b"ets Jul 29 2019 12:21:46", "an ESP32 or ESP8266 starts"),
    "reset of an ESP32": (b"rst:0x1 (POWERON_RESET),boot:0x13", "an ESP32 or ESP8266 starts"),
    "log of ESP-IDF": (b"\x1b[0;32mI (324) cpu_start: Pro cpu up.\x1b[0m", "log of ESP-IDF"),
    "log of Arduino": (b"[E][Wire.cpp:513] requestFrom failed", "Arduino core for ESP32"),
    "log of Zephyr": (b"*** Booting Zephyr OS build v3.5.0 ***", "Zephyr"),
    "brownout": (b"Brownout detector was triggered", "its voltage drops"),
    "panic": (b"Guru Meditation Error: Core  1 panic'ed (LoadProhibited).", "firmware crashes"),
    "watchdog": (b"E (5000) task_wdt: Task watchdog got triggered.", "firmware hangs"),
    "Python": (b"Traceback (most recent call last):", "a program in Python on the device"),
    "MicroPython": (b"MicroPython v1.22.0 on 2023-12-27; Raspberry Pi Pico", "MicroPython"),
    "Linux": (b"[    0.000000] Booting Linux on physical CPU 0x0", "a console of Linux"),
    "login": (b"raspberrypi login: ", "a console of Linux"),
    "modem": (b"AT+CSQ", "AT commands"),
    "answer of a modem": (b"+CME ERROR: 10", "AT commands"),
    "HTML": (b"<!DOCTYPE html><html><body>401</body></html>", "a page in HTML"),
    "HTTP": (b"HTTP/1.1 404 Not Found", "HTTP"),
    "XML": (b'<imu t="1"><ax>0.1</ax></imu>', "XML"),
    # Bytes.
    "zlib": (zlib.compress(LINE), "compressed with zlib"),
    "bzip2": (bz2.compress(LINE), "compressed with bzip2"),
    "xz": (lzma.compress(LINE), "compressed with xz"),
    "MessagePack": (message_pack(GOOD), "MessagePack"),
    "CBOR": (cbor(GOOD), "CBOR"),
    "protobuf": (protobuf([0.1, 0.2, 9.8, 0.0, 0.0, 0.1]), "protobuf"),
    "BSON": (struct.pack("<i", 16) + b"\x01x\0" + struct.pack("<d", 0.5) + b"\0", "BSON"),
    "MQTT": (publish(b"imu/data", LINE), "a packet of MQTT"),
    "UBX": (UBX, "UBX"),
    "MAVLink": (MAVLINK, "MAVLink"),
    "WitMotion": (WIT + bytes([sum(WIT) & 0xFF]), "WitMotion"),
    "Xsens": (b"\xfa\xff\x36\x00\xcb", "Xbus"),
    "MicroStrain": (b"\x75\x65\x80\x0e\x0e\x04\x3e\x7a", "MIP"),
    "SLIP": (b"\xc0\x01\x02\xdb\xdc\x03\xc0", "SLIP"),
    "UTF-16": (TEXT.encode("utf-16"), "UTF-16"),
    "UTF-16 without a mark": (TEXT.encode("utf-16-be"), "UTF-16"),
    "Latin-1": (b'{"unit":"\xb0/s","gx":0.5}', "such as Latin-1"),
    "a damaged line": (b'{"accel_x":0,"acc\xe5l_y":0.5,"a\x83cel_z":9.81', "bytes are damaged"),
    "zeros": (bytes(20), "nothing but bytes 0x00"),
    "a line that floats": (b"\xff" * 40, "nothing but bytes 0xff"),
    "a photo": (b"\xff\xd8\xff\xe0\x00\x10JFIF" + bytes(30), "a JPEG image"),
}


@pytest.mark.parametrize("name", FRAMES)
def test_the_cause_is_told_from_the_frame(name: str) -> None:
    frame, said = FRAMES[name]
    cause = diagnose_frame(frame)
    assert isinstance(cause, Cause), frame
    assert said in cause.text
    assert cause.text.isprintable()
    assert len(cause.text) < 200


HARMLESS = {"ROM of an ESP32", "reset of an ESP32", "log of ESP-IDF", "log of Arduino"} | {
    "log of Zephyr",
    "MicroPython",
    "Linux",
    "login",
    "a missed beginning",
    "missed up to a key",
}


@pytest.mark.parametrize("name", FRAMES)
def test_only_what_devices_say_that_work_is_harmless(name: str) -> None:
    cause = diagnose_frame(FRAMES[name][0])
    assert cause is not None
    assert cause.is_harmless is (name in HARMLESS)


@pytest.mark.parametrize(
    "frame",
    [
        b'{acc -> [0,0,9.8], "t": 5}',
        b"MPU6050 Found!",
        b"hello",
        b"Adafruit ICM20948 test!",
        b"",
        b"  ",
        b"calibrating...",
    ],
)
def test_of_other_text_nothing_is_made_up(frame: bytes) -> None:
    assert diagnose_frame(frame) is None


json_objects = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**60), 2**60) | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(st.text(max_size=9), inner),
).filter(lambda value: isinstance(value, dict) and bool(value))


@given(json_objects, st.sampled_from([message_pack, cbor]))
def test_whatever_is_packed_is_known_by_its_format(value: object, pack: object) -> None:
    assert callable(pack)
    packed = pack(value)
    assume(len(packed) > 4)
    cause = diagnose_frame(packed)
    # A frame of few bytes may be of more than one format, or text.
    assert cause is not None or packed.isascii() or len(packed) < 9


@given(frames, st.binary(max_size=20), st.binary(max_size=20))
def test_no_frame_makes_it_raise_and_what_it_says_fits_into_a_log(
    frame: bytes, before: bytes, after: bytes
) -> None:
    cause = diagnose_frame(before + frame + after)
    if cause is not None:
        assert cause.text.isprintable()
        assert len(cause.text) < 300


@pytest.mark.parametrize("length", [6, 20, 60, 200])
def test_noise_is_seldom_taken_for_anything(length: int) -> None:
    draw = Random(1)
    named = sum(diagnose_frame(draw.randbytes(length)) is not None for _ in range(2000))
    assert named <= 60


HOSTILE = {
    "blanks": b" " * 60_000,
    "braces": b"{" * 60_000,
    "starts": b'{"a' * 20_000,
    "brackets": b"[1," * 20_000,
    "digits": b'{"a":' + b"1" * 60_000,
    "commas": b'{"a":1' + b", " * 30_000,
    "a comma and blanks": b'{"a":1,' + b" " * 60_000 + b"?",
    "keys": b"{a" + b" :a" * 20_000,
    "quotes": b"{'" + b"\\'" * 30_000,
    "numbers": b"1 " * 30_000 + b"x",
    "numbers of two digits": b"11 " * 20_000 + b"x",
    "numbers and blanks": b"1  " * 20_000 + b"x",
    "labels": b"a:1 " * 15_000 + b"x",
    "labels and blanks": b"a:1  " * 12_000 + b"x",
    "tags and blanks": b"a:1" + b"  1" * 20_000 + b"x",
    "a format of zeros": b'{"a":%' + b"0" * 60_000,
    "a time and blanks": b"12:00:00" + b" " * 3_900 + b'x{"a":1}',
    "sentences": b"$GPAAA," * 9_000,
    "a map of maps": b"\x81" * 60_000,
    "arrays of CBOR": b"\x9b\xff\xff\xff\xff\xff\xff\xff\xff" * 6_000,
    "fields": b"\x0a\x02\x08\x01" * 15_000,
    "a bomb": gzip.compress(bytes(10_000_000), mtime=0),
    "a bomb of zlib": zlib.compress(bytes(50_000_000)),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_hostile_frame_takes_no_time(name: str) -> None:
    began_s = time.process_time()
    diagnose_frame(HOSTILE[name])
    # Milliseconds; if one of the patterns tried every way, it would be minutes.
    assert time.process_time() - began_s < 1.0
