"""Bags: recording, playing, reading, editing, comparing and exporting recorded messages.

May import `interfaces`, `node`, `pictures` and `wire`, and what every package may: `base`,
`errors`, `packages` and `plugins`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.bag.base import Bag as Bag
    from teleopctl.bag.editing.checking import BagFault as BagFault, check as check
    from teleopctl.bag.editing.convert_files import (
        InputBag as InputBag,
        read_input_options as read_input_options,
        read_output_options as read_output_options,
    )
    from teleopctl.bag.editing.copying import OutputBag as OutputBag, copy_bags as copy_bags
    from teleopctl.bag.editing.recovering import (
        Recovery as Recovery,
        recover as recover,
        reindex as reindex,
    )
    from teleopctl.bag.export.decoding import DecodedMessage as DecodedMessage, Decoder as Decoder
    from teleopctl.bag.export.plots import (
        Curve as Curve,
        check_plot_file as check_plot_file,
        parse_field as parse_field,
        read_curves as read_curves,
        save_panels as save_panels,
        save_plot as save_plot,
    )
    from teleopctl.bag.export.tables import (
        ExportedTable as ExportedTable,
        TableExport as TableExport,
    )
    from teleopctl.bag.export.video import (
        ExportedVideo as ExportedVideo,
        VideoExport as VideoExport,
    )
    from teleopctl.bag.lerobot.dataset import (
        EpisodeNotes as EpisodeNotes,
        EpisodeRow as EpisodeRow,
        LeRobotDataset as LeRobotDataset,
    )
    from teleopctl.bag.lerobot.episode_folder import (
        EPISODE_RECORD as EPISODE_RECORD,
        EpisodeFolder as EpisodeFolder,
        EpisodeSettings as EpisodeSettings,
        episode_bags as episode_bags,
    )
    from teleopctl.bag.lerobot.export import (
        LeRobotSummary as LeRobotSummary,
        add_episode as add_episode,
        export_lerobot as export_lerobot,
    )
    from teleopctl.bag.lerobot.features import (
        CAMERA_PREFIX as CAMERA_PREFIX,
        STATE_FEATURE as STATE_FEATURE,
        find_actions as find_actions,
        find_cameras as find_cameras,
        find_hand as find_hand,
    )
    from teleopctl.bag.lerobot.sampling import LeRobotOptions as LeRobotOptions
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
        parse_metadata as parse_metadata,
        read_metadata as read_metadata,
        write_metadata as write_metadata,
    )
    from teleopctl.bag.overlaid import OverlaidBag as OverlaidBag
    from teleopctl.bag.player.options import (
        PlayOptions as PlayOptions,
        PlaySelection as PlaySelection,
    )
    from teleopctl.bag.player.player import MARKS_PARAMETER as MARKS_PARAMETER, Player as Player
    from teleopctl.bag.qos_profiles import (
        parse_offered_profiles as parse_offered_profiles,
        read_qos_overrides as read_qos_overrides,
    )
    from teleopctl.bag.recorder.losses import Losses as Losses
    from teleopctl.bag.recorder.options import RecorderOptions as RecorderOptions
    from teleopctl.bag.recorder.recorder import (
        Recorder as Recorder,
        default_bag_folder as default_bag_folder,
    )
    from teleopctl.bag.recorder.selection import (
        Selection as Selection,
        read_static_topics as read_static_topics,
    )
    from teleopctl.bag.recorder.session import RecordingSession as RecordingSession
    from teleopctl.bag.recorder.subscriptions import PauseGate as PauseGate
    from teleopctl.bag.records import (
        NO_TIME_NS as NO_TIME_NS,
        BagAttachment as BagAttachment,
        BagMessage as BagMessage,
        BagTopic as BagTopic,
        TypeText as TypeText,
    )
    from teleopctl.bag.storage.bag import bag_files as bag_files, open_bag as open_bag
    from teleopctl.bag.storage.bag_writer import (
        BagWriter as BagWriter,
        WriterOptions as WriterOptions,
    )
    from teleopctl.bag.storage.storage_settings import (
        chunk_settings as chunk_settings,
        database_settings as database_settings,
    )
    from teleopctl.bag.storage.views import BagPart as BagPart
    from teleopctl.bag.topic_kinds import (
        ServiceCounter as ServiceCounter,
        ServiceCounts as ServiceCounts,
        is_service_event as is_service_event,
        service_of as service_of,
    )
    from teleopctl.bag.type_definitions import (
        known_definition as known_definition,
        known_hash as known_hash,
        register_types as register_types,
    )
    from teleopctl.bag.verify.comparison import (
        ComparedStream as ComparedStream,
        ComparedTraces as ComparedTraces,
        Difference as Difference,
        DifferenceKind as DifferenceKind,
        RecordedMessage as RecordedMessage,
        ReplayComparison as ReplayComparison,
        flatten_fields as flatten_fields,
    )
    from teleopctl.bag.verify.session import (
        STATE_ATTACHMENT as STATE_ATTACHMENT,
        RecordedSession as RecordedSession,
        RecordedTopic as RecordedTopic,
        end_of_run_ns as end_of_run_ns,
        read_commands as read_commands,
        read_session as read_session,
        read_topics as read_topics,
    )
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
