"""Message, service and action types, with their CDR encoding, type hashes and YAML form.

May import `base`, `errors`, `packages` and `plugins` only.
"""

from __future__ import annotations

from teleopctl.base.typed import TYPE_CHECKING

if TYPE_CHECKING:
    from teleopctl.interfaces.annotated_lines import (
        DefinitionLine as DefinitionLine,
        definition_lines as definition_lines,
    )
    from teleopctl.interfaces.cdr import (
        as_numpy as as_numpy,
        check_readable as check_readable,
        class_within as class_within,
        deserialize as deserialize,
        serialize as serialize,
    )
    from teleopctl.interfaces.cdr.prepared_message import PreparedMessage as PreparedMessage
    from teleopctl.interfaces.definition import (
        Definition as Definition,
        Field as Field,
        FieldType as FieldType,
        Shape as Shape,
    )
    from teleopctl.interfaces.field_access import (
        MOST_ELEMENTS as MOST_ELEMENTS,
        NumericField as NumericField,
        field_reader as field_reader,
        numeric_fields as numeric_fields,
    )
    from teleopctl.interfaces.foreign.definition_texts import (
        hash_of_text as hash_of_text,
        message_of_text as message_of_text,
    )
    from teleopctl.interfaces.foreign.idl import (
        IdlStruct as IdlStruct,
        idl_includes as idl_includes,
        read_idl as read_idl,
    )
    from teleopctl.interfaces.message import (
        Message as Message,
        MessageT as MessageT,
        RequestT as RequestT,
        ResponseT as ResponseT,
    )
    from teleopctl.interfaces.parameter_values import (
        VALUE_FIELDS as VALUE_FIELDS,
        AllowableParameterValue as AllowableParameterValue,
        parameter_value_to_python as parameter_value_to_python,
        scalar_parameter_value as scalar_parameter_value,
    )
    from teleopctl.interfaces.parser import parse as parse, split_sections as split_sections
    from teleopctl.interfaces.protocols import (
        ActionType as ActionType,
        FeedbackMessage as FeedbackMessage,
        FeedbackT as FeedbackT,
        GoalT as GoalT,
        ResultResponse as ResultResponse,
        ResultT as ResultT,
        ServiceType as ServiceType,
    )
    from teleopctl.interfaces.slot_types import (
        AbstractGenericString as AbstractGenericString,
        AbstractNestableType as AbstractNestableType,
        AbstractNestedType as AbstractNestedType,
        AbstractSequence as AbstractSequence,
        AbstractString as AbstractString,
        AbstractType as AbstractType,
        AbstractWString as AbstractWString,
        Array as Array,
        BasicType as BasicType,
        BoundedSequence as BoundedSequence,
        BoundedString as BoundedString,
        BoundedWString as BoundedWString,
        NamespacedType as NamespacedType,
        UnboundedSequence as UnboundedSequence,
        UnboundedString as UnboundedString,
        UnboundedWString as UnboundedWString,
        slot_type as slot_type,
    )
    from teleopctl.interfaces.stamps import (
        NANOSECONDS_PER_SECOND as NANOSECONDS_PER_SECOND,
        Stamp as Stamp,
        from_seconds as from_seconds,
        set_stamp as set_stamp,
        split as split,
        to_nanoseconds as to_nanoseconds,
        to_seconds as to_seconds,
    )
    from teleopctl.interfaces.standard import (
        distribution as distribution,
        is_distribution_since as is_distribution_since,
    )
    from teleopctl.interfaces.store import (
        add_definition_text as add_definition_text,
        add_description as add_description,
        complete_definition_text as complete_definition_text,
        definition_file as definition_file,
        definition_text as definition_text,
        described_definition_text as described_definition_text,
        get_action as get_action,
        get_class as get_class,
        get_message as get_message,
        get_service as get_service,
        known_types as known_types,
        list_types as list_types,
        type_description as type_description,
        type_hash as type_hash,
    )
    from teleopctl.interfaces.stubs import write_stubs as write_stubs
    from teleopctl.interfaces.typenames import (
        from_dds as from_dds,
        module_name as module_name,
        normalize as normalize,
        snake_case as snake_case,
        to_dds as to_dds,
    )
    from teleopctl.interfaces.yaml.input import (
        documents_from_yaml as documents_from_yaml,
        message_from_yaml as message_from_yaml,
    )
    from teleopctl.interfaces.yaml.output import (
        message_to_csv as message_to_csv,
        message_to_dict as message_to_dict,
        message_to_yaml as message_to_yaml,
        message_values as message_values,
    )
    from teleopctl.interfaces.yaml.plain import read_plain as read_plain
else:
    from teleopctl.base.lazy import attach

    __getattr__, __dir__, __all__ = attach()
