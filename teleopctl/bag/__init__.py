"""Floor 3: sessions in files: recorded, played, looked at and compared. Knows no other domain."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.bag.editing.checking import BagFault as BagFault, check as check
    from teleopctl.bag.editing.copying import OutputBag as OutputBag, copy_bags as copy_bags
    from teleopctl.bag.editing.input_file import InputBag as InputBag, read_inputs as read_inputs
    from teleopctl.bag.editing.output_file import read_outputs as read_outputs
    from teleopctl.bag.editing.part import BagPart as BagPart
    from teleopctl.bag.editing.recovering import Recovery as Recovery, recover as recover
    from teleopctl.bag.editing.reindexing import reindex as reindex
    from teleopctl.bag.look.curves import (
        Curve as Curve,
        parse_field as parse_field,
        read_curves as read_curves,
    )
    from teleopctl.bag.look.decoding import Decoded as Decoded, Decoder as Decoder
    from teleopctl.bag.look.films import ExportedFilm as ExportedFilm, FilmExport as FilmExport
    from teleopctl.bag.look.lerobot.sampling import (
        LeRobotOptions as LeRobotOptions,
        LeRobotSummary as LeRobotSummary,
        export_lerobot as export_lerobot,
    )
    from teleopctl.bag.look.picture import (
        check_picture_name as check_picture_name,
        save_picture as save_picture,
    )
    from teleopctl.bag.look.tables import ExportedFile as ExportedFile, TableExport as TableExport
    from teleopctl.bag.mcap_file.chunk_builder import (
        ChunkSettings as ChunkSettings,
        Compression as Compression,
        CompressionLevel as CompressionLevel,
    )
    from teleopctl.bag.mcap_file.file_reader import McapFileReader as McapFileReader
    from teleopctl.bag.mcap_file.repair import Repair as Repair, finish_file as finish_file
    from teleopctl.bag.metadata import (
        METADATA_FILE as METADATA_FILE,
        BagFile as BagFile,
        BagMetadata as BagMetadata,
        format_metadata as format_metadata,
        read_metadata as read_metadata,
    )
    from teleopctl.bag.player.options import PlayOptions as PlayOptions
    from teleopctl.bag.player.player import Player as Player
    from teleopctl.bag.player.selection import PlaySelection as PlaySelection
    from teleopctl.bag.qos_overrides import read_qos_overrides as read_qos_overrides
    from teleopctl.bag.recorder.losses import Losses as Losses
    from teleopctl.bag.recorder.options import RecorderOptions as RecorderOptions
    from teleopctl.bag.recorder.recorder import (
        Recorder as Recorder,
        default_folder as default_folder,
    )
    from teleopctl.bag.recorder.selection import Selection as Selection
    from teleopctl.bag.recorder.static_topics import read_static_topics as read_static_topics
    from teleopctl.bag.records import (
        BagAttachment as BagAttachment,
        BagMessage as BagMessage,
        BagTopic as BagTopic,
        TypeText as TypeText,
    )
    from teleopctl.bag.service_events import (
        ServiceCounter as ServiceCounter,
        ServiceCounts as ServiceCounts,
        is_service_event as is_service_event,
        service_of as service_of,
    )
    from teleopctl.bag.storage.bag import (
        Bag as Bag,
        bag_files as bag_files,
        open_bag as open_bag,
    )
    from teleopctl.bag.storage.bag_writer import (
        BagWriter as BagWriter,
        WriterOptions as WriterOptions,
    )
    from teleopctl.bag.storage.database_settings import database_settings as database_settings
    from teleopctl.bag.storage.presets import chunk_settings as chunk_settings
    from teleopctl.bag.verify.comparison import (
        ComparedStream as ComparedStream,
        Difference as Difference,
        DifferenceKind as DifferenceKind,
        Recorded as Recorded,
        Verdict as Verdict,
        leaves as leaves,
    )
    from teleopctl.bag.verify.session import (
        RecordedSession as RecordedSession,
        RecordedTopic as RecordedTopic,
        end_of_run as end_of_run,
        read_commands as read_commands,
        read_session as read_session,
        read_topics as read_topics,
    )
    from teleopctl.bag.verify.traces import ComparedTraces as ComparedTraces
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
