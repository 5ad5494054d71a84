//! The parameters of a live run in ROS 2: the services of `rcl_interfaces`, for `ros2 param` and
//! clients in any language.

use ros2_client::parameters::{ParameterDescriptor, raw};
use ros2_client::rcl_interfaces::{
    DescribeParametersRequest, DescribeParametersResponse, GetParameterTypesRequest,
    GetParameterTypesResponse, GetParametersRequest, GetParametersResponse, ListParametersRequest,
    ListParametersResponse, ListParametersResult, SetParametersAtomicallyResponse,
    SetParametersRequest, SetParametersResponse,
};
use ros2_client::{ParameterValue, Server};

use super::Ros2Error;
use super::outlet::Topics;
use crate::mailbox::Mailbox;
use crate::parameters::{Parameters, Value};

/// The servers of the services.
pub(super) struct Servers {
    pub get: Server<GetParametersRequest, GetParametersResponse>,
    pub types: Server<GetParameterTypesRequest, GetParameterTypesResponse>,
    pub list: Server<ListParametersRequest, ListParametersResponse>,
    pub describe: Server<DescribeParametersRequest, DescribeParametersResponse>,
    pub set: Server<SetParametersRequest, SetParametersResponse>,
    pub set_atomically: Server<SetParametersRequest, SetParametersAtomicallyResponse>,
}

impl Servers {
    pub fn new(outlet: &mut Topics) -> Result<Self, Ros2Error> {
        const PACKAGE: &str = "rcl_interfaces";
        Ok(Self {
            get: outlet.serve("get_parameters", PACKAGE, "GetParameters")?,
            types: outlet.serve("get_parameter_types", PACKAGE, "GetParameterTypes")?,
            list: outlet.serve("list_parameters", PACKAGE, "ListParameters")?,
            describe: outlet.serve("describe_parameters", PACKAGE, "DescribeParameters")?,
            set: outlet.serve("set_parameters", PACKAGE, "SetParameters")?,
            set_atomically: outlet.serve(
                "set_parameters_atomically",
                PACKAGE,
                "SetParametersAtomically",
            )?,
        })
    }
}

/// Answers their requests.
pub(super) struct Answers<'a> {
    pub parameters: &'a Parameters,
    pub desk: &'a Mailbox,
}

impl Answers<'_> {
    /// Returns the values of these names; empty for an unknown name.
    fn values(&self, names: &[String]) -> Vec<ParameterValue> {
        let all = self.parameters.now();
        let value = |name: &String| {
            let known = all.iter().find(|(known, _)| known == name);
            known.map_or(ParameterValue::NotSet, |(_, value)| to_ros(value))
        };
        names.iter().map(value).collect()
    }

    pub fn get(&self, request: &GetParametersRequest) -> GetParametersResponse {
        let values = self.values(&request.names);
        GetParametersResponse {
            values: values.into_iter().map(raw::ParameterValue::from).collect(),
        }
    }

    pub fn types(&self, request: &GetParameterTypesRequest) -> GetParameterTypesResponse {
        let values = self.values(&request.names);
        let types = values.iter().map(ParameterValue::to_parameter_type_raw);
        GetParameterTypesResponse {
            values: types.collect(),
        }
    }

    /// Without prefixes all names match; names have no dots, so a prefix is a name.
    pub fn list(&self, request: &ListParametersRequest) -> ListParametersResponse {
        let all = self.parameters.now().into_iter();
        let names = all.map(|(name, _)| name.to_owned());
        let wanted = |name: &String| request.prefixes.is_empty() || request.prefixes.contains(name);
        ListParametersResponse {
            result: ListParametersResult {
                names: names.filter(wanted).collect(),
                prefixes: Vec::new(),
            },
        }
    }

    pub fn describe(&self, request: &DescribeParametersRequest) -> DescribeParametersResponse {
        let values = self.values(&request.names);
        let described = request.names.iter().zip(values).map(|(name, value)| {
            let mut descriptor = match value {
                ParameterValue::NotSet => ParameterDescriptor::unknown(name),
                value => ParameterDescriptor::from_value(name, &value),
            };
            descriptor.description.clear();
            raw::ParameterDescriptor::from(descriptor)
        });
        DescribeParametersResponse {
            values: described.collect(),
        }
    }

    pub fn set(&self, request: &SetParametersRequest) -> SetParametersResponse {
        let results = request.parameter.iter().map(|one| self.set_one(one));
        SetParametersResponse {
            results: results.collect(),
        }
    }

    /// Sets all or none.
    pub fn set_atomically(
        &self,
        request: &SetParametersRequest,
    ) -> SetParametersAtomicallyResponse {
        let refused = request.parameter.iter().find_map(|parameter| {
            let value = from_ros(parameter.value.clone().into());
            self.parameters.change(&parameter.name, &value).err()
        });
        let result = match refused {
            Some(why) => Err(why).into(),
            None => {
                let reasons = request.parameter.iter().map(|one| self.set_one(one).reason);
                let reasons: Vec<String> = reasons.filter(|reason| !reason.is_empty()).collect();
                raw::SetParametersResult {
                    successful: true,
                    reason: reasons.join("; "),
                }
            }
        };
        SetParametersAtomicallyResponse { result }
    }

    /// A value out of range is rejected, with the range.
    fn set_one(&self, parameter: &raw::Parameter) -> raw::SetParametersResult {
        let value = from_ros(parameter.value.clone().into());
        match self.parameters.set(&parameter.name, &value) {
            Ok(said) => {
                if let Some(note) = &said {
                    self.desk.say(note);
                }
                raw::SetParametersResult {
                    successful: true,
                    reason: said.unwrap_or_default(),
                }
            }
            Err(why) => Err(why).into(),
        }
    }
}

fn to_ros(value: &Value) -> ParameterValue {
    match value {
        Value::Number(number) => ParameterValue::Double(*number),
        Value::Count(count) => ParameterValue::Integer(*count),
        Value::Flag(flag) => ParameterValue::Boolean(*flag),
        Value::Word(word) => ParameterValue::String(word.clone()),
        Value::Other => ParameterValue::NotSet,
    }
}

fn from_ros(value: ParameterValue) -> Value {
    match value {
        ParameterValue::Double(number) => Value::Number(number),
        ParameterValue::Integer(count) => Value::Count(count),
        ParameterValue::Boolean(flag) => Value::Flag(flag),
        ParameterValue::String(word) => Value::Word(word),
        _ => Value::Other,
    }
}
